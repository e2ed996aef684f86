class_name PvsTests
# Baked visibility where nothing is drawn: bake, save, load, damage, movement, cancel, bad settings.

static func run(test: SceneTree) -> void:
	var scene := Node3D.new()
	test.root.add_child(scene)
	var root := Rooms.build(scene, 4, 6)
	var cam := Camera3D.new()
	cam.position = Vector3(-12, 1.6, -12)
	cam.rotation.y = -0.75 * PI
	scene.add_child(cam)
	cam.make_current()
	var world := CulletWorld.new()
	world.occlusion = false
	scene.add_child(world)
	world.cull_now()
	var plain: int = world.statistics().visible
	# Two of three come to no end.
	var shares := []
	var ends := []
	var baker := CulletPvsBaker.new()
	baker.progressed.connect(func(share): shares.append(share))
	baker.finished.connect(func(pvs): ends.append(pvs))
	test.check("a bake begins", baker.start(world, root) and baker.is_running())
	test.check("one at a time", not baker.start(world, root))
	baker.cancel()
	test.check("a cancelled bake keeps nothing", ends == [null] and baker.get_error() == "cancelled" and baker.get_result() == null)
	test.check("and can begin again", baker.start(world, root))
	for i in 3:
		await test.process_frame
	baker.cancel()
	test.check("a bake is cancelled while threads work", ends == [null, null] and not baker.is_running())
	baker.start(world, root)
	while baker.is_running():
		await test.process_frame
		OS.delay_msec(2)
	var pvs: CulletPvs = baker.get_result()
	test.check("a bake ends with its result", ends.size() == 3 and pvs != null and ends[2] == pvs and pvs.is_valid())
	if pvs == null:
		print("  ", baker.get_error())
		return
	var sorted := shares.duplicate()
	sorted.sort()
	test.check("progress only grows", shares.size() > 0 and shares == sorted and baker.get_progress() == 1.0)
	test.check("rooms are exact", pvs.is_exact() and pvs.missing() == Vector2.ZERO)
	test.check("rooms are found", pvs.cell_count() >= 16)
	test.check("all nodes are named", pvs.node_count() == root.get_child_count())
	var seen := pvs.seen_from(cam.position)
	print("  of %d nodes %d are seen from %d cells" % [pvs.node_count(), seen.size(), pvs.cell_count()])
	test.check("some are seen from a room", seen.size() > 5 and seen.size() < root.get_child_count() * 0.7)
	test.check("a thing in the room is seen", seen.has("t0_0_0"))
	test.check("outside of all nothing is known", pvs.seen_from(Vector3(0, 500, 0)).is_empty())
	# In use.
	world.pvs = [pvs, null]
	world.cull_now()
	var s := world.statistics()
	test.check("sets hide", s.pvs_hidden > root.get_child_count() / 4 and s.visible < plain and s.pvs_cameras == 1)
	test.check("nothing is stale", s.pvs_stale == 0)
	for file: String in ["user://pvs.res", "user://pvs.tres"]:
		test.check(file + " is saved", ResourceSaver.save(pvs, file) == OK)
		var loaded: CulletPvs = ResourceLoader.load(file, "", ResourceLoader.CACHE_MODE_IGNORE)
		test.check(file + " is the same", loaded.is_valid() and loaded.data == pvs.data and loaded.root == pvs.root)
		world.pvs = [loaded]
		world.cull_now()
		test.check(file + " hides the same", world.statistics().pvs_hidden == s.pvs_hidden)
	world.pvs = [load("user://pvs.res")]
	world.cull_now()
	test.check("as the manual has it", world.statistics().pvs_hidden == s.pvs_hidden)
	var again := await Rooms.bake(world, root, func(b): b.threads = 1)
	test.check("the same bytes, by any number of threads", again.data == pvs.data)
	# Two at once, one of another scene, which is not there.
	var other: CulletPvs = pvs.duplicate()
	other.root = ^"../Nowhere"
	world.pvs = [other, pvs]
	world.cull_now()
	test.check("one whose root is not there does no harm", world.statistics().pvs_hidden == s.pvs_hidden)
	# Damage.
	var bytes := pvs.data
	for at: int in [0, 9, 40, bytes.size() / 2, bytes.size() - 9]:
		var damaged := bytes.duplicate()
		damaged[at] ^= 0x55
		var bad := CulletPvs.new()
		bad.root = pvs.root
		bad.data = damaged
		world.pvs = [bad]
		world.cull_now()
		test.check("byte %d damaged: ignored" % at, not bad.is_valid() and world.statistics().pvs_hidden == 0)
	var cut := CulletPvs.new()
	cut.data = bytes.slice(0, 100)
	test.check("cut short: ignored", not cut.is_valid() and cut.cell_count() == 0 and cut.seen_from(Vector3.ZERO).is_empty())
	world.pvs = [pvs]
	world.cull_now()
	# A thing moves: it alone falls out.
	var far: Node3D = root.get_node("t3_3_0")
	var near: Node3D = root.get_node("t0_0_0")
	test.check("a far thing is hidden", not seen.has("t3_3_0"))
	var place := far.position
	far.position = cam.position - cam.basis.z
	world.cull_now()
	var moved := world.statistics()
	test.check("a thing that moved is culled as usual", moved.pvs_stale == 1 and moved.pvs_hidden == s.pvs_hidden - 1 and world.is_visible_from(cam, far))
	far.position = place
	world.cull_now()
	test.check("and back again", world.statistics().pvs_stale == 0 and world.statistics().pvs_hidden == s.pvs_hidden)
	near.free() # Too small to hide.
	world.cull_now()
	test.check("one that is gone is counted", world.statistics().pvs_stale == 1 and world.statistics().pvs_hidden > 0)
	# A wall that the camera's cell sees: the sets of that cell hide nothing more.
	var wall: Node3D = root.get_node("b1_0_0")
	test.check("the wall is seen", seen.has("b1_0_0"))
	wall.position.y += 0.5
	world.cull_now()
	test.check("past a wall that moved everything may be seen", world.statistics().pvs_hidden == 0)
	wall.position.y -= 0.5
	world.cull_now()
	test.check("until it is back", world.statistics().pvs_hidden > 0)
	wall.visible = false
	world.cull_now()
	test.check("or shown again", world.statistics().pvs_hidden == 0)
	wall.visible = true
	wall.layers = 2
	world.cull_now()
	test.check("or in its layer", world.statistics().pvs_hidden == 0)
	wall.layers = 1
	var mesh: BoxMesh = (wall as MeshInstance3D).mesh
	var size := mesh.size
	mesh.size = size * 0.9
	world.cull_now()
	await test.process_frame
	world.cull_now()
	test.check("or of its size", world.statistics().pvs_hidden == 0)
	mesh.size = size
	await test.process_frame
	world.cull_now()
	test.check("as it was baked", world.statistics().pvs_hidden > 0)
	# A wall far from the camera does not matter to it.
	(root.get_node("w4_3_1") as Node3D).position.y += 0.5
	world.cull_now()
	test.check("a wall that the cell does not see does not matter", world.statistics().pvs_hidden > 0 and world.statistics().pvs_stale == 2)
	# Cameras for which sets are of no use.
	cam.cull_mask = 2
	world.cull_now()
	test.check("a camera that does not see the walls", world.statistics().pvs_hidden == 0)
	cam.cull_mask = 1
	cam.projection = Camera3D.PROJECTION_ORTHOGONAL
	world.cull_now()
	test.check("parallel lines have no eye", world.statistics().pvs_hidden == 0)
	cam.projection = Camera3D.PROJECTION_PERSPECTIVE
	cam.position = Vector3(-8, 1.6, -11)
	world.cull_now()
	test.check("nor has one in a wall a cell", world.statistics().pvs_hidden == 0)
	world.pvs = []
	world.cull_now()
	test.check("without sets nothing is hidden by them", world.statistics().pvs_hidden == 0)
	await others(test, world, root, cam)
	scene.free()
	await test.process_frame

# Grids, boxes and bad settings.
static func others(test: SceneTree, world: CulletWorld, root: Node3D, cam: Camera3D) -> void:
	var low := Vector3(-15.5, 1.0, -15.5)
	var by_grid := func(baker: CulletPvsBaker):
		baker.method = CulletPvsBaker.SAMPLED
		baker.bounds = AABB(low, Vector3(31, 1, 31))
		baker.cell_size = Vector3(8, 4, 8)
		baker.rays = 300_000
	var sampled := await Rooms.bake(world, root, by_grid)
	test.check("a grid is sampled, and says so", sampled.is_valid() and not sampled.is_exact() and sampled.cell_count() == 16)
	test.check("what it may lack is estimated", sampled.missing().x > 0 and sampled.missing().y >= sampled.missing().x)
	cam.position = Vector3(-12, 1.6, -12)
	world.pvs = [sampled]
	world.cull_now()
	test.check("it hides too", world.statistics().pvs_hidden > 0)
	# Behind a wall without doors.
	var yard := Node3D.new()
	root.get_parent().add_child(yard)
	Rooms.box(yard, "wall", Vector3(0, 50, 0), Vector3(30, 20, 1), Color.GRAY)
	for x in range(-3, 4):
		Rooms.box(yard, "behind%d" % x, Vector3(x, 50, -6), Vector3.ONE * 0.5, Color.RED)
		Rooms.box(yard, "before%d" % x, Vector3(x, 50, 3), Vector3.ONE * 0.5, Color.RED)
	# Two more there whose opaque parts are hidden, with glass or an outline that is seen above the wall.
	var parts := ArrayMesh.new()
	for part: Array in [[0.5, 0.0, BaseMaterial3D.TRANSPARENCY_DISABLED], [2.0, 25.0, BaseMaterial3D.TRANSPARENCY_ALPHA]]:
		var body := BoxMesh.new()
		body.size = Vector3.ONE * part[0]
		var arrays := body.get_mesh_arrays()
		for i in arrays[Mesh.ARRAY_VERTEX].size():
			arrays[Mesh.ARRAY_VERTEX][i].y += part[1]
		parts.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
		var material := StandardMaterial3D.new()
		material.transparency = part[2]
		parts.surface_set_material(parts.get_surface_count() - 1, material)
	var glassy := MeshInstance3D.new()
	glassy.name = "glassy"
	glassy.mesh = parts
	glassy.position = Vector3(0, 50, -8)
	yard.add_child(glassy)
	var outlined := Rooms.box(yard, "outlined", Vector3(1, 50, -8), Vector3.ONE * 1.5, Color.RED)
	var outline := StandardMaterial3D.new()
	outline.grow = true
	outline.grow_amount = 30.0
	outlined.material_override.next_pass = outline
	var by_boxes := func(baker: CulletPvsBaker):
		baker.smallest = 0.1
		baker.method = CulletPvsBaker.PROVED
		baker.voxels = 128
		baker.boxes = [AABB(Vector3(-1, 49, 5), Vector3(2, 2, 2)), AABB(Vector3(-1, 49, 7), Vector3(2, 2, 2))]
	var proved := await Rooms.bake(world, yard, by_boxes)
	test.check("boxes are cells", proved.is_valid() and proved.is_exact() and proved.cell_count() == 2 and proved.boxes().size() == 2)
	cam.position = Vector3(0, 50, 6.9)
	world.pvs = [proved, sampled]
	world.cull_now()
	test.check("what is proved is hidden, across two cells", world.statistics().pvs_hidden == 7)
	cam.position = Vector3(0, 50, 4.9)
	world.cull_now()
	test.check("outside of the boxes nothing is", world.statistics().pvs_hidden == 0)
	world.pvs = []
	var baker := CulletPvsBaker.new()
	baker.cell_size = Vector3(0, NAN, 1)
	test.check("a cell without a size is refused", not baker.start(world, root) and baker.get_error().contains("cell_size"))
	baker.cell_size = Vector3.ONE
	var bad := [["voxels", 100_000, CulletPvsBaker.PROVED], ["rays", 0, CulletPvsBaker.SAMPLED], ["voxel_size", 0.001, CulletPvsBaker.ROOMS]]
	for one: Array in bad:
		var made := await Rooms.bake(world, root, func(b):
			b.method = one[2]
			b.set(one[0], one[1]))
		test.check(one[0] + " out of range gives no result", made == null)
	var empty := Node3D.new()
	root.add_child(empty)
	test.check("nothing to bake gives no result", await Rooms.bake(world, empty) == null)
	var dropped := CulletPvsBaker.new()
	dropped.start(world, root)
	for i in 3:
		await test.process_frame
	dropped = null
	await test.process_frame
	test.check("a baker that is let go ends", true)
