extends Case
# Houses move, shrink, are hidden, shown, added and removed.

var houses: Array = []

func build() -> void:
	City.build(self, 8, 8)
	sun(true)
	camera(Vector3(-4, 1.7, 60), 0.4)
	houses = get_tree().get_nodes_in_group("house")

func steps() -> int:
	return 24

func most_drawn() -> float:
	return 0.4

func step(i: int) -> void:
	var what: String = ["move", "remove", "hide", "show", "add", "shrink"][i % 6]
	for k in 12:
		var house: MeshInstance3D = houses[rng.randi() % houses.size()]
		match what:
			"move":
				house.position += Vector3(rng.randf_range(-8, 8), 0, rng.randf_range(-8, 8))
			"shrink":
				house.scale *= 0.5
			"remove":
				houses.erase(house)
				house.queue_free()
			"hide":
				house.visible = false
			"show":
				for h in houses:
					h.visible = true
			"add":
				var at := Vector3(rng.randf_range(-20, 12), 3, rng.randf_range(0, 50))
				houses.append(City.add(self, house.mesh, house.material_override, at, Vector3(3, 6, 3), "house"))
