extends Case
# Lamps with shadows that move and are switched, behind and before walls.

var lamps: Array[Light3D] = []
var things: Array = []

func build() -> void:
	ground(60)
	wall(Vector3(0, 3, -10), Vector3(14, 6, 0.5))
	for x in range(-9, 10, 3):
		for z in [-6, -13, -16, 6]:
			things.append(wall(Vector3(x, 1, z), Vector3(0.6, 2, 0.6), Color.from_hsv(absf(x) / 13.0, 0.6, 0.9)))
	for i in 4:
		var lamp: Light3D = OmniLight3D.new() if i < 2 else SpotLight3D.new()
		lamp.set_param(Light3D.PARAM_RANGE, 14.0)
		lamp.shadow_enabled = true
		lamp.light_energy = 3
		lamp.position = Vector3(5 * i - 7, 3, -14 if i % 2 else 3)
		add_child(lamp)
		lamps.append(lamp)
	camera(Vector3(0, 1.7, 4))

func steps() -> int:
	return 12

func step(i: int) -> void:
	cameras[0].rotation.y = 0.4 * sin(i * 1.3)
	lamps[i % 4].position += Vector3(2, 0.5, -1.5)
	if i == 4:
		lamps[0].visible = false
	if i == 5:
		lamps[1].shadow_enabled = false
	if i == 6:
		lamps[0].visible = true
	if i == 7:
		lamps[1].shadow_enabled = true
	things[(i * 5) % things.size()].position += Vector3(0.5, 0.5, 0.5)
	# Out of the picture and back: what was hidden meanwhile must cast again.
	if i == 8:
		cameras[0].rotation.y = PI
	if i == 9:
		cameras[0].rotation.y = 0
