extends Case
# A walk through a city in the sun, with shadows.

func build() -> void:
	City.build(self, 10, 8)
	sun(true)
	camera(Vector3(-4, 1.7, 60))

func steps() -> int:
	return 12

func step(i: int) -> void:
	City.walk(cameras[0], 0.35 + 0.02 * i)

func most_drawn() -> float:
	return 0.25

# Houses that no camera sees, near enough for their shadows to be seen.
func victims_of_lost_casters() -> Array:
	var houses := get_tree().get_nodes_in_group("house")
	return houses.filter(func(h): return h.global_position.distance_to(cameras[0].global_position) < 60 and cameras[0].is_position_behind(h.global_position))
