extends Case
# Visibility ranges, which fade, and a parent that stands for its parts from afar.

func build() -> void:
	ground()
	var fades := wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	fades.visibility_range_end = 14
	fades.visibility_range_end_margin = 4
	fades.visibility_range_fade_mode = GeometryInstance3D.VISIBILITY_RANGE_FADE_SELF
	var far := wall(Vector3(0, 2, -16), Vector3(6, 4, 0.5), Color.CADET_BLUE)
	far.visibility_range_begin = 20
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			var thing := wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
			if z == -18:
				thing.visibility_parent = NodePath("../" + far.name)
	sun(true)
	camera(Vector3(0, 1.7, 2))

func steps() -> int:
	return 10

func step(i: int) -> void:
	cameras[0].position.z = 8.0 - 2.0 * i
