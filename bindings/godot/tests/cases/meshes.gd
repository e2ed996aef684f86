extends Case
# Meshes that are swapped and changed by a script, of what hides and of what is hidden.

var front: MeshInstance3D
var things: Array = []

func build() -> void:
	ground()
	front = wall(Vector3(0, 3, -10), Vector3.ONE)
	front.mesh.size = Vector3(16, 6, 0.5)
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			things.append(wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9)))
	sun(true)
	camera(Vector3(0, 1.7, 2))

func steps() -> int:
	return 10

func most_drawn() -> float:
	return 0.8

func step(i: int) -> void:
	match i:
		1:
			things[19].mesh.size = Vector3(1, 20, 1)
		2:
			var tall := CylinderMesh.new()
			tall.height = 20
			things[22].mesh = tall
		3:
			front.mesh.size = Vector3(5, 6, 0.5)
		4:
			front.mesh = SphereMesh.new()
		5:
			var arrays := BoxMesh.new().get_mesh_arrays()
			var made := ArrayMesh.new()
			made.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
			front.mesh = made
			front.scale = Vector3(16, 6, 1)
		6:
			front.mesh.clear_surfaces()
		7:
			var torus := TorusMesh.new()
			front.mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, torus.get_mesh_arrays())
		8:
			var lines := ImmediateMesh.new()
			lines.surface_begin(Mesh.PRIMITIVE_TRIANGLES)
			for p in [Vector3(-5, 0, 0), Vector3(0, 12, 0), Vector3(5, 0, 0)]:
				lines.surface_add_vertex(p)
			lines.surface_end()
			things[25].mesh = lines
			front.mesh = BoxMesh.new()
		9:
			front.mesh = null
