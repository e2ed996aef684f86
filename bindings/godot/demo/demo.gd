extends Node3D
# A city, an interior with rooms, and the two put together: boxes, made by this script. Copy addons/cullet with its library into this
# folder first. `godot --path . -- shot=FILE` saves a picture of the frozen city from above, and ends.

const HELP := "Space: who culls   Tab: scene   F: freeze and see from above   arrows: walk and turn"
const SCENES := ["city", "rooms", "city with rooms"]
const MODES := ["nothing but the frustum", "Godot's own occlusion culling", "cullet"]

var mode := 2
var scene := 0
var root: Node3D
var world: CulletWorld
var things: Array[MeshInstance3D] = []
var eye := Camera3D.new()
var above := Camera3D.new()
var bounds: MeshInstance3D
var text := Label.new()
var box := BoxMesh.new()
var materials: Array[StandardMaterial3D] = []
var rng := RandomNumberGenerator.new()

func _ready() -> void:
	for i in 12:
		var material := StandardMaterial3D.new()
		material.albedo_color = Color.from_hsv(i / 12.0, 0.35, 0.85)
		materials.append(material)
	var sun := DirectionalLight3D.new()
	sun.rotation_degrees = Vector3(-50, 30, 0)
	add_child(sun)
	for camera: Camera3D in [eye, above]:
		camera.far = 2000
		add_child(camera)
	text.position = Vector2(10, 8)
	text.add_theme_color_override("font_outline_color", Color.BLACK)
	text.add_theme_constant_override("outline_size", 6)
	add_child(text)
	load_scene(0)
	for argument in OS.get_cmdline_user_args():
		if argument.begins_with("shot="):
			await shoot(argument.trim_prefix("shot="))

func load_scene(which: int) -> void:
	freeze(false)
	if root:
		root.free()
	scene = which
	things.clear()
	rng.seed = 7
	root = Node3D.new()
	add_child(root)
	world = CulletWorld.new()
	root.add_child(world)
	add_box(Vector3(0, -0.5, 0), Vector3(900, 1, 900), 3, false)
	if scene != 1:
		city(24)
	if scene != 0:
		rooms(Vector3(-4, 0, 20) if scene == 2 else Vector3.ZERO, 6)
	eye.transform = Transform3D(Basis(), Vector3(-4, 1.7, 60 if scene != 1 else 3))
	set_mode(mode)

func add_box(at: Vector3, size: Vector3, colour: int, occludes: bool) -> void:
	var node := MeshInstance3D.new()
	node.mesh = box
	node.material_override = materials[colour % 12]
	node.transform = Transform3D(Basis.from_scale(size), at)
	root.add_child(node)
	things.append(node)
	if occludes:
		# For Godot's own culling; cullet needs none.
		var shape := BoxOccluder3D.new()
		shape.size = size
		var occluder := OccluderInstance3D.new()
		occluder.occluder = shape
		occluder.position = at
		root.add_child(occluder)

func city(blocks: int) -> void:
	for bx in blocks:
		for bz in blocks:
			var corner := Vector3((bx - blocks / 2) * 28.0, 0, (bz - blocks / 2) * 28.0)
			if scene == 2 and absf(corner.x) < 60 and absf(corner.z) < 60:
				continue
			for i in 4:
				var h := rng.randf_range(8.0, 40.0)
				add_box(corner + Vector3(5 + 10 * (i % 2), h * 0.5, 5 + 10 * (i / 2)), Vector3(9.9, h, 9.9), rng.randi(), true)
			for i in 12:
				var s := rng.randf_range(0.3, 1.2)
				var at := Vector3(rng.randf_range(-1.5, 21.5), s * 0.5, -1 if i % 2 else 21)
				add_box(corner + (at if i % 4 < 2 else Vector3(at.z, at.y, at.x)), Vector3(s, s, s), rng.randi(), false)

# Rooms of eight metres, with a door in each wall.
func rooms(at: Vector3, count: int) -> void:
	var half := count * 4.0
	for i in count + 1:
		for k in count:
			for side: int in [-1, 1]:
				var along := k * 8.0 - half + 4.0 + side * 2.5
				var across := i * 8.0 - half
				add_box(at + Vector3(along, 1.5, across), Vector3(3, 3, 0.2), 5, true)
				add_box(at + Vector3(across, 1.5, along), Vector3(0.2, 3, 3), 7, true)
	add_box(at + Vector3(0, 3.1, 0), Vector3(count * 8, 0.2, count * 8), 1, true)
	for i in count * count * 20:
		var place := Vector3(rng.randf_range(-half, half), 0.3, rng.randf_range(-half, half))
		add_box(at + place, Vector3.ONE * rng.randf_range(0.2, 0.6), rng.randi(), false)

func set_mode(to: int) -> void:
	mode = to
	world.enabled = mode == 2
	get_viewport().use_occlusion_culling = mode == 1

# Keeps what is drawn, and shows it from above with the bounds of what is hidden.
func freeze(on: bool) -> void:
	if bounds:
		bounds.free()
		bounds = null
	if world:
		world.frozen = on and mode == 2
	if not on or mode != 2:
		eye.make_current()
		return
	var lines := ImmediateMesh.new()
	lines.surface_begin(Mesh.PRIMITIVE_LINES)
	for thing in things:
		if thing.scale.y > 2 and not world.is_visible_from(eye, thing):
			var b := thing.transform * AABB(-Vector3.ONE / 2, Vector3.ONE)
			for i in 8:
				for axis: int in [1, 2, 4]:
					if not i & axis:
						lines.surface_add_vertex(b.get_endpoint(i))
						lines.surface_add_vertex(b.get_endpoint(i | axis))
	lines.surface_add_vertex(eye.position)
	lines.surface_add_vertex(eye.position + Vector3.UP * 60)
	lines.surface_end()
	bounds = MeshInstance3D.new()
	bounds.mesh = lines
	var material := StandardMaterial3D.new()
	material.shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
	material.albedo_color = Color.ORANGE_RED
	bounds.material_override = material
	add_child(bounds)
	above.look_at_from_position(eye.position + Vector3(60, 150, 130), eye.position + Vector3(0, 0, -60))
	above.make_current()

func _process(delta: float) -> void:
	eye.rotation.y += Input.get_axis("ui_right", "ui_left") * delta
	eye.position -= eye.basis.z * Input.get_axis("ui_down", "ui_up") * delta * 8
	var view := get_viewport().get_viewport_rid()
	var kind := RenderingServer.VIEWPORT_RENDER_INFO_TYPE_VISIBLE
	var drawn := RenderingServer.viewport_get_render_info(view, kind, RenderingServer.VIEWPORT_RENDER_INFO_OBJECTS_IN_FRAME)
	var numbers := world.statistics()
	var ours := "   %d seen, %d us" % [numbers.visible, numbers.us] if mode == 2 else ""
	text.text = "%s, %d meshes: %s\n%d drawn, %.1f ms a frame%s\n%s" % [SCENES[scene], things.size(), MODES[mode], drawn, delta * 1000, ours, HELP]

func _unhandled_key_input(event: InputEvent) -> void:
	if not event.is_pressed() or event.is_echo():
		return
	match event.keycode:
		KEY_SPACE:
			freeze(false)
			set_mode((mode + 1) % 3)
		KEY_TAB:
			load_scene((scene + 1) % 3)
		KEY_F:
			freeze(not world.frozen)

func shoot(path: String) -> void:
	for i in 60:
		await RenderingServer.frame_post_draw
	freeze(true)
	for i in 60:
		await RenderingServer.frame_post_draw
	get_viewport().get_texture().get_image().save_png(path)
	# All scenes, so that a script error shows. Not Godot's own culling, which crashes on some machines: see the README's traps.
	for i in 6:
		if i % 2 == 0:
			load_scene(i / 2)
		set_mode(i % 2 * 2)
		for k in 4:
			await RenderingServer.frame_post_draw
		print(text.text.get_slice("\n", 0), " ", text.text.get_slice("\n", 1))
	get_tree().quit()
