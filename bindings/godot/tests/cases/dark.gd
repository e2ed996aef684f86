extends Case
# Lamps without shadows: behind a wall, behind the camera, moving into what is seen and out of it, with other layers.

var lamps: Array[Light3D] = []

func build() -> void:
	# Tiles, so that what is lit behind the wall is hidden too.
	for x in range(-5, 6):
		for z in range(-8, 4):
			wall(Vector3(4 * x, -0.5, 4 * z), Vector3(4, 1, 4), Color.DARK_OLIVE_GREEN)
	wall(Vector3(0, 4, -10), Vector3(44, 8, 0.5))
	for x in range(-9, 10, 3):
		for z in [-6, -13, -16, 6]:
			wall(Vector3(x, 1, z), Vector3(0.6, 2, 0.6), Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
	for i in 10:
		var lamp: Light3D = OmniLight3D.new() if i % 2 else SpotLight3D.new()
		lamp.set_param(Light3D.PARAM_RANGE, 4.0)
		lamp.light_energy = 6
		lamp.position = Vector3(4 * (i % 5) - 8, 2, -18 if i < 5 else 0)
		lamp.rotation.x = -1.2
		add_child(lamp)
		lamps.append(lamp)
	camera(Vector3(0, 1.7, 4))

func steps() -> int:
	return 14

func step(i: int) -> void:
	cameras[0].rotation.y = 0.4 * sin(i * 1.3)
	# Through the wall, and back.
	lamps[0].position.z += 4 if i < 7 else -4
	lamps[1].position.z = -6 if i % 2 else -18
	if i == 3:
		lamps[2].set_param(Light3D.PARAM_RANGE, 30.0)
	if i == 5:
		lamps[2].set_param(Light3D.PARAM_RANGE, 4.0)
		lamps[3].shadow_enabled = true
	if i == 6:
		lamps[3].position.z = -5
	if i == 7:
		lamps[3].shadow_enabled = false
		lamps[4].visible = false
	if i == 8:
		lamps[4].position.z = -5
		lamps[4].visible = true
	if i == 9:
		cameras[0].rotation.y = PI
	if i == 10:
		cameras[0].rotation.y = 0
		lamps[6].reparent(lamps[7])
	if i == 11:
		remove_child(lamps[1])
	if i == 12:
		lamps[1].position.z = -6
		add_child(lamps[1])

func least_dark() -> int:
	return 4

# Lamps that still light what is seen, hidden too early.
func victims_of_early_dark() -> Array:
	return [lamps[0], lamps[7]]
