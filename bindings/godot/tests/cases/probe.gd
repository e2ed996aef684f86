extends Case
# A mirror ball and a probe that is drawn in each frame: it sees what no camera does.

func build() -> void:
	City.build(self, 6, 4)
	sun()
	var metal := StandardMaterial3D.new()
	metal.metallic = 1.0
	metal.roughness = 0.0
	var ball := SphereMesh.new()
	mesh(ball, Vector3(-4, 1.5, 54)).material_override = metal
	var probe := ReflectionProbe.new()
	probe.size = Vector3(60, 60, 60)
	probe.max_distance = 60
	probe.position = Vector3(-4, 10, 54)
	probe.update_mode = ReflectionProbe.UPDATE_ALWAYS
	add_child(probe)
	camera(Vector3(-4, 1.7, 57))

func steps() -> int:
	return 2

# A probe is drawn over several frames.
func frames() -> int:
	return 24

func step(i: int) -> void:
	cameras[0].rotation.y = 0.1 * i

func most_drawn() -> float:
	return 0.7

func victims_of_probe() -> Array:
	var houses := get_tree().get_nodes_in_group("house")
	return houses.filter(func(h): return cameras[0].is_position_behind(h.global_position))
