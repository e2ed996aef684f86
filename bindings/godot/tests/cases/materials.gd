extends Case
# A wall and things behind it whose materials change, without any signal.

var front: MeshInstance3D
var things: Array = []

func build() -> void:
	ground()
	front = wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			things.append(wall(Vector3(x, 1, z), Vector3.ONE, Color.from_hsv(absf(x) / 13.0, 0.6, 0.9)))
	warm()
	sun()
	camera(Vector3(0, 1.7, 2))

# Every kind of material, far off but in the picture, for Godot makes their pipelines in the background.
func warm() -> void:
	var kinds: Array[Material] = []
	for i in 6:
		kinds.append(StandardMaterial3D.new())
	kinds[0].transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
	kinds[1].cull_mode = BaseMaterial3D.CULL_FRONT
	kinds[2].no_depth_test = true
	kinds[3].grow = true
	kinds[4].albedo_color = Color.RED
	kinds.append(shader("shader_type spatial; render_mode cull_disabled; void fragment() { ALBEDO = vec3(0.5); if (fract(UV.x * 20.0) < 0.5) discard; }"))
	kinds.append(shader("shader_type spatial; void vertex() { VERTEX.y *= 0.2; }"))
	kinds.append(shader("shader_type spatial; void vertex() { VERTEX.y += 9.0; }"))
	for i in kinds.size():
		wall(Vector3(i * 3 - 12, 14, -30), Vector3.ONE).material_override = kinds[i]
		var seen_through := wall(Vector3(i * 3 - 12, 17, -30), Vector3.ONE)
		seen_through.transparency = 0.5

func steps() -> int:
	return 14

func most_drawn() -> float:
	return 0.8

func shader(code: String) -> ShaderMaterial:
	var material := ShaderMaterial.new()
	material.shader = Shader.new()
	material.shader.code = code
	return material

func step(i: int) -> void:
	var material: StandardMaterial3D = front.material_override if front.material_override is StandardMaterial3D else null
	match i:
		1:
			material.transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
			material.albedo_color.a = 0.5
		2:
			material.transparency = BaseMaterial3D.TRANSPARENCY_DISABLED
		3:
			material.cull_mode = BaseMaterial3D.CULL_FRONT
		4:
			material.cull_mode = BaseMaterial3D.CULL_BACK
			material.no_depth_test = true
		5:
			material.no_depth_test = false
			front.transparency = 0.5
		6:
			front.transparency = 0.0
			front.material_override = shader("shader_type spatial; render_mode cull_disabled; void fragment() { ALBEDO = vec3(0.5); if (fract(UV.x * 20.0) < 0.5) discard; }")
		7:
			front.material_override = null
		8:
			front.set_surface_override_material(0, shader("shader_type spatial; void vertex() { VERTEX.y *= 0.2; }"))
		9:
			front.set_surface_override_material(0, null)
			var through := StandardMaterial3D.new()
			through.no_depth_test = true
			things[20].material_override = through
			world.refresh(things[20])
		10:
			var high := shader("shader_type spatial; void vertex() { VERTEX.y += 9.0; }")
			things[19].material_override = high
			world.refresh(things[19])
		11:
			var grown := StandardMaterial3D.new()
			grown.grow = true
			grown.grow_amount = 4.0
			things[22].material_override = grown
			world.refresh(things[22])
		12:
			var overlay := StandardMaterial3D.new()
			overlay.no_depth_test = true
			overlay.albedo_color = Color.RED
			things[16].material_overlay = overlay
			world.refresh(things[16])
		13:
			front.visibility_range_end = 4.0
