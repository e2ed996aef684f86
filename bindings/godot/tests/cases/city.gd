extends Case
# A walk through a city.

func build() -> void:
	City.build(self, 10, 8)
	sun()
	camera(Vector3(-4, 1.7, 60))

func steps() -> int:
	return 12

func step(i: int) -> void:
	City.walk(cameras[0], 0.35 + 0.02 * i)

func most_drawn() -> float:
	return 0.25

func victims_of_loss() -> Array:
	var houses := get_tree().get_nodes_in_group("house")
	return houses.filter(func(h): return h.global_position.distance_to(cameras[0].global_position) < 30)
