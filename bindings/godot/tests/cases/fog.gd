extends Case
# Fog that the sun lights, where the renderer has it: shadows of what nobody sees lie in the air.

func build() -> void:
	City.build(self, 6, 2)
	sun(true)
	var environment := Environment.new()
	environment.volumetric_fog_enabled = true
	environment.volumetric_fog_density = 0.02
	environment.volumetric_fog_temporal_reprojection_enabled = false
	var node := WorldEnvironment.new()
	node.environment = environment
	add_child(node)
	camera(Vector3(-4, 1.7, 60))

func steps() -> int:
	return 4

func step(i: int) -> void:
	City.walk(cameras[0], 0.35 + 0.03 * i)
