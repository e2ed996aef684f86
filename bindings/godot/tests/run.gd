extends Node
# godot --path . -- CASE ...: draws each step of the cases without the culler and with it, and compares all pixels.

func _ready() -> void:
	run.call_deferred()

func run() -> void:
	var failed := 0
	for name_ in OS.get_cmdline_user_args():
		var parts := name_.split(":")
		var mutant := parts[1] if parts.size() > 1 else ""
		# Godot makes pipelines in the background, and what has none yet is drawn by others, with other roundings: pictures that
		# differ are drawn again, when all pipelines are there. Places of lamps in the atlas of their shadows depend on the clock, too.
		# A culler that errs errs each time.
		var passed := false
		for attempt in 1 if mutant else 5:
			if not passed:
				passed = await one(parts[0], mutant)
		failed += int(not passed)
	print("%d failed" % failed)
	get_tree().quit(1 if failed else 0)

# Plays all frames of a case that is in motion twice from its beginning, and compares frame by frame. Needs --fixed-fps.
func replay(name_: String) -> bool:
	var films := []
	var drawn := 0.0
	for on in [false, true]:
		var case: Case = load("res://cases/%s.gd" % name_).new()
		case.rng.seed = 3
		add_child(case)
		case.build()
		case.world = CulletWorld.new()
		case.world.enabled = false
		case.add_child(case.world)
		for i in 20:
			await RenderingServer.frame_post_draw
		while Engine.get_frames_drawn() % 192 != 0:
			await RenderingServer.frame_post_draw
		# From the same step of physics on, and the same place in the jitter.
		await get_tree().physics_frame
		case.world.enabled = on
		var film := []
		for i in case.steps():
			case.step(i)
			await RenderingServer.frame_post_draw
			film.append(case.viewports().map(Pictures.of))
			if on:
				var numbers: Dictionary = case.world.statistics()
				drawn += numbers.visible / maxf(numbers.instances, 1.0) / case.steps()
		films.append(film)
		var most := case.most_drawn()
		case.queue_free()
		await get_tree().process_frame
		await get_tree().process_frame
		if on:
			var wrong := 0
			for i in film.size():
				for v in film[i].size():
					wrong += Pictures.differing(film[i][v], films[0][i][v])
			var still := Pictures.differing(film[0][0], film[-1][0])
			var ok := wrong == 0 and drawn <= most and still > 0
			print("%s %s: %d wrong pixels in %d frames, %.0f%% drawn" % ["ok" if ok else "FAILED", name_, wrong, film.size(), drawn * 100])
			return ok
	return false

func one(name_: String, mutant: String) -> bool:
	if name_.begins_with("film_"):
		return await replay(name_)
	var case: Case = load("res://cases/%s.gd" % name_).new()
	case.rng.seed = 3
	add_child(case)
	case.build()
	case.world = CulletWorld.new()
	case.world.enabled = false
	case.add_child(case.world)
	await Pictures.settle(case.viewports())
	await case.begin()
	case.world.enabled = true
	var breaker := Mutants.new(case, mutant)
	var wrong := 0
	var drawn := 0.0
	var us := 0.0
	var dark := 0
	for i in case.steps():
		case.step(i)
		for k in case.frames():
			await RenderingServer.frame_post_draw
		var with := case.viewports().map(Pictures.of)
		var numbers: Dictionary = case.world.statistics()
		drawn += numbers.visible / maxf(numbers.instances, 1.0) / case.steps()
		us += numbers.us / case.steps()
		dark = maxi(dark, numbers.dark_lamps)
		breaker.rest()
		case.world.enabled = false
		for k in case.frames():
			await RenderingServer.frame_post_draw
		var without := case.viewports().map(Pictures.of)
		case.world.enabled = true
		await RenderingServer.frame_post_draw
		var here := 0
		for v in with.size():
			here += Pictures.differing(with[v], without[v])
		if here > 0 and mutant == "":
			print("  wrong at step ", i, ": ", here, " ", numbers)
		wrong += here
	breaker.end()
	var last: Dictionary = case.world.statistics()
	var ok := wrong == 0 and drawn <= case.most_drawn() and dark >= case.least_dark()
	if mutant != "":
		ok = wrong > 0
	case.queue_free()
	await get_tree().process_frame
	await get_tree().process_frame
	print("%s %s%s: %d wrong pixels, %.0f%% of %d drawn, %.0f us" % ["ok" if ok else "FAILED", name_, " broken by " + mutant if mutant else "", wrong, drawn * 100, last.instances, us])
	return ok
