extends Case
# Walls of a GridMap, which hide what is behind them while they stand.

var grid: GridMap

func build() -> void:
	var library := MeshLibrary.new()
	library.create_item(0)
	var box := BoxMesh.new()
	box.size = Vector3(2, 2, 2)
	library.set_item_mesh(0, box)
	grid = GridMap.new()
	grid.mesh_library = library
	grid.cell_size = Vector3(2, 2, 2)
	add_child(grid)
	for x in range(-6, 7):
		for y in 4:
			grid.set_cell_item(Vector3i(x, y, -6), 0)
	for x in range(-16, 17, 2):
		for z in [-16, -20, -26]:
			wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 17.0, 0.6, 0.9))
	ground()
	sun(true)
	camera(Vector3(0, 1.7, 0))

func steps() -> int:
	return 8

func step(i: int) -> void:
	look_about(i % 4)
	match i:
		2:
			grid.set_cell_item(Vector3i(0, 0, -6), GridMap.INVALID_CELL_ITEM)
		4:
			grid.position.x += 5.0
		5:
			grid.visible = false
		6:
			grid.visible = true
			grid.clear()

func most_drawn() -> float:
	return 0.8
