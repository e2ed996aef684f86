extends Case
# A wall of CSG that gets a hole.

var hole: CSGBox3D

func build() -> void:
	var body := CSGBox3D.new()
	body.size = Vector3(18, 8, 1)
	body.position = Vector3(0, 3, -9)
	add_child(body)
	hole = CSGBox3D.new()
	hole.operation = CSGShape3D.OPERATION_SUBTRACTION
	hole.size = Vector3(2, 2, 3)
	hole.position = Vector3(0, 20, 0)
	body.add_child(hole)
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9))
	ground()
	sun(true)
	camera(Vector3(0, 1.7, 0))

func steps() -> int:
	return 8

func step(i: int) -> void:
	look_about(i % 4)
	if i == 2:
		hole.position = Vector3(0, -1.5, 0)
	if i == 5:
		hole.position.x = 3.0
	if i == 6:
		hole.get_parent().size.y = 3.0
