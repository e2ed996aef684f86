extends Case
# All ways to cast shadows, of things that the camera sees and that it does not.

var things: Array = []

func build() -> void:
	ground()
	wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	for x in range(-12, 13, 2):
		for z in [-14, -8, 6]:
			var size := Vector3(1, 2 + things.size() % 7, 1)
			var thing := wall(Vector3(x, size.y * 0.5, z), size, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
			thing.cast_shadow = things.size() % 4 as GeometryInstance3D.ShadowCastingSetting
			if thing.cast_shadow == GeometryInstance3D.SHADOW_CASTING_SETTING_DOUBLE_SIDED:
				thing.mesh = QuadMesh.new()
			things.append(thing)
	sun(true)
	camera(Vector3(0, 1.7, 2))

func steps() -> int:
	return 12

func step(i: int) -> void:
	look_about(i % 6)
	if i == 3:
		for k in things.size():
			things[k].cast_shadow = (k + 1) % 4 as GeometryInstance3D.ShadowCastingSetting
			world.refresh(things[k])
	if i == 6:
		for child in get_children():
			if child is DirectionalLight3D:
				child.rotation_degrees = Vector3(-20, 10, 0)
	if i == 8:
		for child in get_children():
			if child is DirectionalLight3D:
				child.light_angular_distance = 4.0
	if i == 10:
		for child in get_children():
			if child is DirectionalLight3D:
				child.directional_shadow_max_distance = 12.0
