extends Case
# Physics at 20 steps a second, drawn at 60: nodes and the camera are drawn between the places that they have.

var movers: Array = []
var ticks := 0

func build() -> void:
	get_tree().physics_interpolation = true
	Engine.physics_ticks_per_second = 20
	ground()
	wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	for x in range(-12, 13, 2):
		movers.append(wall(Vector3(x, 1, -16), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9)))
	sun(true)
	camera(Vector3(0, 1.7, 2))

func _physics_process(_delta: float) -> void:
	if world == null or not started:
		return
	ticks += 1
	for i in movers.size():
		movers[i].position.y = 1.0 + 9.0 * absf(sin(0.35 * ticks + i))
	movers[3].position.z = -16 + 13.0 * (ticks % 2)
	cameras[0].position.x = 5.0 * sin(0.3 * ticks)
	cameras[0].rotation.y = 0.3 * sin(0.5 * ticks)

var started := false

func step(_i: int) -> void:
	world.follow = 2
	started = true

func steps() -> int:
	return 48

func _exit_tree() -> void:
	get_tree().physics_interpolation = false
	Engine.physics_ticks_per_second = 60
