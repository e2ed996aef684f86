extends Case
# What hides by hand: a shader's wall with a CulletOccluder, a shape that stands for itself, a wall that must not hide.

var mark: Node3D

func build() -> void:
	ground()
	var front := wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	var material := ShaderMaterial.new()
	material.shader = Shader.new()
	material.shader.code = "shader_type spatial; void vertex() { COLOR.r = VERTEX.y; } void fragment() { ALBEDO = COLOR.rgb; }"
	front.material_override = material
	mark = CulletOccluder.new()
	front.add_child(mark)
	# Glass, as far as the culler is told.
	var other := wall(Vector3(14, 3, -10), Vector3(10, 6, 0.5))
	other.add_child(NoCulletOccluder.new())
	for x in range(-14, 19, 2):
		for z in [-14, -18, -24]:
			wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 19.0, 0.6, 0.9))
	sun(true)
	camera(Vector3(0, 1.7, 2))

func steps() -> int:
	return 8

func most_drawn() -> float:
	return 0.9

func step(i: int) -> void:
	look_about(i % 3)
	if i == 4:
		mark.free()
