extends SceneTree
# godot --headless --path . --script res://headless.gd: counts, bad input, queries, where nothing is drawn.

var failed := 0

func check(what: String, is_right: bool) -> void:
	print("ok " if is_right else "FAILED ", what)
	failed += 0 if is_right else 1

func _initialize() -> void:
	run.call_deferred()

func add(parent: Node, at: Vector3) -> MeshInstance3D:
	var node := MeshInstance3D.new()
	node.mesh = BoxMesh.new()
	node.position = at
	parent.add_child(node)
	return node

# What the editor shows beside a node.
func warnings(node: Node) -> PackedStringArray:
	return node.get_configuration_warnings_now()

func run() -> void:
	var scene := Node3D.new()
	root.add_child(scene)
	var count := City.build(scene, 8, 16)
	var cam := Camera3D.new()
	cam.position = Vector3(-4, 1.7, 60)
	scene.add_child(cam)
	cam.make_current()
	var world := CulletWorld.new()
	scene.add_child(world)
	await process_frame
	world.cull_now()
	var s := world.statistics()
	check("all are followed", s.instances == count)
	check("most are hidden", s.visible < count / 10)
	check("some are seen", s.visible > 10)
	check("without lights nothing is kept for its shadow", s.shadow_only == 0)
	check("one world has no warning", warnings(world).is_empty())
	# Bad input.
	var odd := add(scene, Vector3.ZERO)
	odd.transform.origin = Vector3(NAN, 0, 0)
	var flat := add(scene, Vector3(0, 1, 20))
	flat.scale = Vector3.ZERO
	var huge := add(scene, Vector3(0, 1, 20))
	huge.scale = Vector3.ONE * 1e30
	var empty := MeshInstance3D.new()
	empty.mesh = ArrayMesh.new()
	scene.add_child(empty)
	var none := MeshInstance3D.new()
	scene.add_child(none)
	var multi := MultiMeshInstance3D.new()
	scene.add_child(multi)
	var grid := GridMap.new()
	scene.add_child(grid)
	world.cull_now()
	s = world.statistics()
	check("odd nodes are followed", s.instances == count + 6)
	for i in 3:
		odd.transform.origin = Vector3(INF if i == 0 else NAN, i, 0)
		world.cull_now()
	check("a NaN is drawn", world.statistics().visible >= 1)
	for node in [odd, flat, huge, empty, none, multi, grid]:
		node.free()
	world.cull_now()
	check("what is freed is let go", world.statistics().instances == count)
	var fleeting := add(scene, Vector3.ZERO)
	fleeting.position.x = 3
	fleeting.visible = false
	fleeting.free()
	world.cull_now()
	check("a node may come, move and go in one frame", world.statistics().instances == count)
	# A camera that shows nothing that can be reckoned with.
	cam.position.x = NAN
	world.cull_now()
	check("a camera at no place hides nothing", world.statistics().visible == count)
	cam.position.x = -4
	world.cull_now()
	check("and then hides again", world.statistics().visible < count / 10)
	world.budget = -1.0
	world.buffer_width = 0
	world.cull_now()
	check("settings out of range do no harm", world.statistics().visible <= count)
	world.budget = 200.0
	world.buffer_width = 640
	# Two in one world.
	var second := CulletWorld.new()
	scene.add_child(second)
	second.cull_now()
	check("a second one does nothing", second.statistics().instances == 0)
	check("and says so in the tree", warnings(second).size() == 1 and warnings(world).is_empty())
	world.free()
	second.cull_now()
	check("it takes over when the first goes", second.statistics().instances == count)
	second.enabled = false
	check("what is off has given all back", second.enabled == false)
	second.enabled = true
	second.rebuild()
	second.cull_now()
	check("it can be rebuilt", second.statistics().instances == count)
	# Marks.
	var mark := CulletOccluder.new()
	scene.get_child(0).add_child(mark)
	var unmark := NoCulletOccluder.new()
	scene.get_child(1).add_child(unmark)
	second.cull_now()
	mark.free()
	unmark.free()
	second.cull_now()
	check("marks come and go", second.statistics().instances == count)
	lamps(scene, second, cam)
	queries(second, cam)
	Explained.run(check, scene, second, cam)
	var told := []
	var note := func(camera: Camera3D, node: Node3D, is_seen: bool): told.append([camera, node, is_seen])
	second.sight_changed.connect(note)
	var watched := get_nodes_in_group("house")[0] as Node3D
	cam.look_at(watched.position)
	cam.position = watched.position + Vector3(0, 60, 20)
	cam.look_at(watched.position)
	second.watch(watched, true)
	second.cull_now()
	cam.rotation.x = 1.5
	second.cull_now()
	await process_frame
	check("a node that comes into sight and leaves it is reported", told == [[cam, watched, true], [cam, watched, false]])
	second.sight_changed.disconnect(note)
	# A scene that is swapped.
	scene.free()
	await process_frame
	var other := Node3D.new()
	root.add_child(other)
	var third := CulletWorld.new()
	other.add_child(third)
	third.cull_now()
	check("without a camera nothing is hidden", third.statistics().instances == third.statistics().visible)
	RenderingServer.force_draw()
	check("a forced frame is drawn", true)
	other.free()
	await process_frame
	await PvsTests.run(self)
	print("%d failed" % failed)
	quit(1 if failed else 0)

func lamps(scene: Node, world: CulletWorld, cam: Camera3D) -> void:
	# The ground is in the reach of all lamps near it.
	var near := OmniLight3D.new()
	near.position = cam.position + Vector3(0, 0, -3)
	scene.add_child(near)
	var high := SpotLight3D.new()
	high.position = cam.position + Vector3(0, 300, 0)
	scene.add_child(high)
	world.cull_now()
	check("a lamp that lights nothing seen is hidden", world.statistics().dark_lamps == 1)
	high.position.y = 3
	world.cull_now()
	check("a lamp that comes down to the street is shown", world.statistics().dark_lamps == 0)
	high.position.y = 300
	high.shadow_enabled = true
	world.cull_now()
	check("a lamp with shadows is not hidden", world.statistics().dark_lamps == 0)
	high.shadow_enabled = false
	var fog := WorldEnvironment.new()
	fog.environment = Environment.new()
	fog.environment.volumetric_fog_enabled = true
	scene.add_child(fog)
	world.cull_now()
	check("nor one that lights fog", world.statistics().dark_lamps == 0)
	fog.free()
	world.cull_now()
	check("without fog it is hidden again", world.statistics().dark_lamps == 1)
	world.lamps = false
	world.cull_now()
	check("hiding lamps can be switched off", world.statistics().dark_lamps == 0)
	world.lamps = true
	near.free()
	high.free()

func queries(world: CulletWorld, cam: Camera3D) -> void:
	if not world.has_method("line_of_sight"):
		return
	check("a house blocks the view", not world.line_of_sight(Vector3(-4, 2, 60), Vector3(60, 2, 5)))
	check("a street does not", world.line_of_sight(Vector3(-4, 2, 60), Vector3(-4, 2, 40)))
	var near: Node3D = null
	var far: Node3D = null
	for house in cam.get_tree().get_nodes_in_group("house"):
		var d: float = house.position.distance_to(cam.position)
		if near == null or d < near.position.distance_to(cam.position):
			near = house
		if far == null or d > far.position.distance_to(cam.position):
			far = house
	cam.look_at(near.position)
	world.cull_now()
	check("what is before the camera is visible from it", world.is_visible_from(cam, near))
	check("what is behind the city is not", not world.is_visible_from(cam, far))
	check("a camera sees where it looks", world.who_sees(near.position + (cam.position - near.position) * 0.9).has(cam))
	check("and not behind itself", not world.who_sees(cam.position + (cam.position - near.position)).has(cam))
