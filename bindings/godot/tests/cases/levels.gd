extends Case
# A house with Godot's automatic levels, from near and afar.

func build() -> void:
	ground()
	var house := CapsuleMesh.new()
	house.radius = 5.0
	house.height = 12.0
	var importer := ImporterMesh.new()
	importer.add_surface(Mesh.PRIMITIVE_TRIANGLES, house.get_mesh_arrays())
	importer.generate_lods(60, 25, [])
	var made: ArrayMesh = importer.get_mesh()
	for x in [-7, 0, 7]:
		mesh(made, Vector3(x, 4, -20), Vector3.ONE, Color.STEEL_BLUE)
	for x in range(-12, 13, 2):
		for z in [-32, -36, -40]:
			wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
	sun(true)
	camera(Vector3(0, 1.7, 0))

func steps() -> int:
	return 10

# Occluders come from another thread: some seconds may pass before the first.
func step(i: int) -> void:
	if i == 0:
		for k in 600:
			if world.statistics().waiting == 0 and k > 2:
				break
			OS.delay_msec(20)
			world.cull_now()
	cameras[0].position = Vector3(3.0 * sin(i), 1.7, 8.0 * i * i - 8)

func most_drawn() -> float:
	return 0.9
