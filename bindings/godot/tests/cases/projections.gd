extends Case
# Orthographic cameras, shifted frusta, near and far planes.

func build() -> void:
	City.build(self, 6, 8)
	sun(true)
	camera(Vector3(-4, 1.7, 60))

func steps() -> int:
	return 10

func step(i: int) -> void:
	var cam := cameras[0]
	match i:
		1:
			cam.set_orthogonal(30, 0.1, 300)
		2:
			cam.rotation.y = 0.7
		3:
			cam.set_orthogonal(60, -50, 300)
		4:
			cam.set_frustum(0.08, Vector2(0.03, 0.02), 0.05, 300)
		5:
			cam.set_perspective(120, 0.01, 4000)
		6:
			cam.set_perspective(5, 1, 90)
		7:
			cam.keep_aspect = Camera3D.KEEP_WIDTH
			cam.set_perspective(75, 0.05, 300)
		8:
			cam.h_offset = 2.0
			cam.v_offset = 5.0
		9:
			cam.rotation = Vector3(-1.2, 0.3, 0.6)
			cam.position.y = 60
