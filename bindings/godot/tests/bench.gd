extends Node3D
# godot --path . res://bench.tscn -- blocks=32 things=16 shadows=0 frames=20 modes=plain,cullet,godot rays=512
# A city drawn in turn with nothing, with cullet and with Godot's own occlusion culling: nodes drawn, times, wrong pixels.

var args := {"blocks": "32", "things": "16", "shadows": "0", "pancake": "20", "frames": "20", "modes": "plain,cullet,godot", "rays": "512", "spots": "20", "rounds": "2", "follow": "0", "width": "640", "budget": "200"}
var cam: Camera3D
var world: CulletWorld
var occluders := 0

func _ready() -> void:
	for argument in OS.get_cmdline_user_args():
		var parts := argument.split("=")
		args[parts[0]] = parts[1]
	run.call_deferred()

func run() -> void:
	var root := Node3D.new()
	add_child(root)
	var count := City.build(root, int(args.blocks), int(args.things))
	var sun := DirectionalLight3D.new()
	sun.shadow_enabled = args.shadows == "1"
	sun.directional_shadow_max_distance = 150
	sun.directional_shadow_pancake_size = float(args.pancake)
	sun.rotation_degrees = Vector3(-50, 30, 0)
	add_child(sun)
	cam = Camera3D.new()
	cam.far = 2000
	add_child(cam)
	City.walk(cam, 0.0)
	world = CulletWorld.new()
	world.follow = int(args.follow)
	world.buffer_width = int(args.width)
	world.budget = float(args.budget)
	world.enabled = false
	root.add_child(world)
	var view := get_viewport()
	RenderingServer.viewport_set_measure_render_time(view.get_viewport_rid(), true)
	RenderingServer.viewport_set_occlusion_rays_per_thread(int(args.rays))
	await Pictures.settle([view])
	world.enabled = true
	var t := Time.get_ticks_usec()
	world.cull_now()
	print("%s, %d instances; first frame of the culler %.1f ms: %s" % [RenderingServer.get_current_rendering_method(), count, (Time.get_ticks_usec() - t) / 1000.0, world.statistics()])
	for i in 130 if int(args.follow) == 0 else 3:
		await RenderingServer.frame_post_draw
	print("then ", world.statistics())
	await pictures(root)
	for motion in ["standing", "walking"]:
		for round_ in int(args.rounds):
			for mode in args.modes.split(","):
				await times(root, motion, mode)
	await jump()
	get_tree().quit()

func set_mode(mode: String, root: Node) -> void:
	world.enabled = mode == "cullet"
	get_viewport().use_occlusion_culling = mode == "godot"
	if mode == "godot" and occluders == 0:
		occluders = City.add_occluders(root)
		for i in 12:
			await RenderingServer.frame_post_draw

func objects() -> Array:
	var rid := get_viewport().get_viewport_rid()
	return [0, 1].map(func(kind): return RenderingServer.viewport_get_render_info(rid, kind, RenderingServer.VIEWPORT_RENDER_INFO_OBJECTS_IN_FRAME))

func pictures(root: Node) -> void:
	var wrong := {}
	var bad := {}
	for i in int(args.spots):
		City.walk(cam, 0.9 * i / int(args.spots))
		var first := PackedInt32Array()
		for mode in ["plain"] + Array(args.modes.split(",")).filter(func(m): return m != "plain"):
			await set_mode(mode, root)
			await RenderingServer.frame_post_draw
			var picture := Pictures.of(get_viewport())
			if mode == "plain":
				first = picture
			else:
				var here := Pictures.differing(first, picture)
				wrong[mode] = wrong.get(mode, 0) + here
				bad[mode] = bad.get(mode, 0) + int(here > 0)
	print("wrong pixels at %s places: %s in %s pictures" % [args.spots, wrong, bad])

func times(root: Node, motion: String, mode: String) -> void:
	await set_mode(mode, root)
	City.walk(cam, 0.2)
	for i in 4:
		await RenderingServer.frame_post_draw
	var frames := []
	var cpu := []
	var ours := []
	var drawn := [0, 0]
	var parts := {}
	var changed := 0
	var last := Time.get_ticks_usec()
	for i in int(args.frames):
		if motion == "walking":
			City.walk(cam, 0.2 + i * 0.002)
		await RenderingServer.frame_post_draw
		var now := Time.get_ticks_usec()
		frames.append((now - last) / 1000.0)
		last = now
		cpu.append(RenderingServer.viewport_get_measured_render_time_cpu(get_viewport().get_viewport_rid()) + RenderingServer.get_frame_setup_time_cpu())
		var o := objects()
		drawn = [drawn[0] + o[0], drawn[1] + o[1]]
		if mode == "cullet":
			var numbers := world.statistics()
			ours.append(numbers.us)
			changed += numbers.changed
			for part in ["us_follow", "us_cull", "us_casters", "us_tell"]:
				parts[part] = parts.get(part, 0.0) + numbers[part] / int(args.frames)
	for list in [frames, cpu, ours]:
		list.sort()
	var k: int = frames.size()
	var own := ""
	if mode == "cullet":
		own = ", own us median %.0f least %.0f, changed %d a frame, means %s" % [ours[k / 2], ours[0], changed / k, parts]
	print("%s %s: frame ms median %.1f least %.1f, render cpu ms median %.2f, drawn %d + %d in shadow maps%s" % [motion, mode, frames[k / 2], frames[0], cpu[k / 2], drawn[0] / k, drawn[1] / k, own])

# The camera jumps to the other end and looks the other way.
func jump() -> void:
	world.enabled = true
	for i in 4:
		cam.position = Vector3(-4, 40, 200 if i % 2 else -200)
		cam.rotation = Vector3(-0.3, 0 if i % 2 else PI, 0)
		await RenderingServer.frame_post_draw
		print("jump: ", world.statistics())
