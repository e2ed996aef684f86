class_name Explained
# What `explain`, `hidden_by` and `preview` say of a city, held against what the culler does. `check` takes a sentence and whether it holds.

static func run(check: Callable, scene: Node, world: CulletWorld, cam: Camera3D) -> void:
	cam.transform = Transform3D(Basis(), Vector3(-4, 1.7, 60))
	world.cull_now()
	var houses := cam.get_tree().get_nodes_in_group("house")
	var agree := 0
	var hidden: Array[Node3D] = []
	for house: Node3D in houses:
		var text := world.explain(cam, house)
		agree += 1 if text.contains(" is drawn: ") == world.is_visible_from(cam, house) else 0
		if text.contains("it lies behind "):
			hidden.append(house)
	check.call("all explanations agree with what is drawn", agree == houses.size())
	check.call("many houses are explained to lie behind others", hidden.size() > houses.size() / 4)
	what_hides(check, world, cam, hidden)
	var node := MeshInstance3D.new()
	node.mesh = BoxMesh.new()
	node.name = "Crate"
	node.position = cam.position + Vector3(0, 0, -3)
	scene.add_child(node)
	var says := func(words: String) -> bool:
		world.cull_now()
		var text: String = world.explain(cam, node)
		if not text.contains(words):
			print("  ", text)
		return text.contains(words)
	check.call("a crate before the camera is drawn", says.call("Crate is drawn: "))
	check.call("and hides", says.call("It hides what lies behind it"))
	node.position.z = cam.position.z + 3
	check.call("behind the camera it is said to be so, and how far", says.call("it lies 2.5 units behind the camera's near plane"))
	node.position = cam.position + Vector3(-90, 0, -3)
	check.call("to the left it is outside of the left side", says.call("outside of the picture's left side"))
	node.position = cam.position + Vector3(0, 0, -3)
	node.layers = 2
	cam.cull_mask = 1
	check.call("in another layer it is said to be so", says.call("shares no layer"))
	cam.cull_mask = 0xfffff
	node.layers = 1
	node.visible = false
	check.call("an invisible one is said to be so", says.call("`visible`"))
	node.visible = true
	node.ignore_occlusion_culling = true
	world.refresh(node)
	check.call("one that ignores culling is said to be so", says.call("`ignore_occlusion_culling` is on"))
	node.free()
	check.call("what draws nothing is left to Godot", world.explain(cam, cam).contains("left to Godot"))
	previews(check, scene, world, cam)

static func what_hides(check: Callable, world: CulletWorld, cam: Camera3D, hidden: Array[Node3D]) -> void:
	if hidden.is_empty():
		return
	var house := hidden[hidden.size() / 2]
	check.call("a name of what hides it is in the text", world.explain(cam, house).contains(world.hidden_by(cam, house)[0].name))
	var taken: Array[Node3D] = []
	for i in 40:
		var by: Array[Node3D] = world.hidden_by(cam, house)
		if by.is_empty():
			break
		for hider in by:
			hider.visible = false
			taken.append(hider)
		world.cull_now()
	check.call("without all that hides it, a house is drawn", taken.size() > 0 and world.is_visible_from(cam, house))
	for hider in taken:
		hider.visible = true
	world.cull_now()
	check.call("with them it is hidden again", not world.is_visible_from(cam, house))

static func previews(check: Callable, scene: Node, world: CulletWorld, cam: Camera3D) -> void:
	var sun := DirectionalLight3D.new()
	sun.shadow_enabled = true
	sun.rotation_degrees = Vector3(-40, 130, 0)
	scene.add_child(sun)
	var high := OmniLight3D.new()
	high.position = cam.position + Vector3(0, 300, 0)
	scene.add_child(high)
	# Behind the camera.
	var probe := ReflectionProbe.new()
	probe.size = Vector3.ONE * 40
	probe.max_distance = 20
	probe.position = cam.position + Vector3(0, 0, 40)
	scene.add_child(probe)
	world.cull_now()
	var s := world.statistics()
	var size: Vector2i = cam.get_window().size
	var preview: CulletPreview = world.preview(cam, size)
	var n := preview.counts()
	check.call("a preview draws what a frame draws", n.nodes == s.instances and n.drawn + n.always + n.probe == s.visible)
	check.call("and has its shadows and lamps", n.shadow_only == s.shadow_only and n.casters == s.gone and n.shadow_only > 0 and n.dark_lamps == 1)
	check.call("a probe keeps what is near it", n.probe > 5)
	check.call("each node has one fate", n.drawn + n.always + n.probe + n.layer + n.frustum + n.occlusion + n.pvs == n.nodes)
	var house: Node3D = cam.get_tree().get_nodes_in_group("house")[0]
	check.call("a box has two corners and twelve edges", preview.boxes("drawn").size() == 2 * n.drawn and preview.lines("drawn").size() == 24 * n.drawn)
	check.call("the words of a preview are those of a frame", preview.explain(house).get_slice("\n", 0) == world.explain(cam, house).get_slice("\n", 0))
	check.call("a frustum has twelve edges", preview.frustum(50.0).size() == 24)
	# Another camera, which draws nothing.
	var other := Camera3D.new()
	scene.add_child(other)
	other.position = Vector3(0, 400, 0)
	other.rotation.x = -PI / 2
	var above: CulletPreview = world.preview(other, Vector2i(400, 400))
	check.call("from above another camera sees more", above.counts().drawn > 2 * n.drawn)
	check.call("and that hides and shows nothing", world.statistics() == s and preview.counts() == n)
	other.position.x = NAN
	check.call("a camera at no place has no preview", world.preview(other, Vector2i(400, 400)) == null)
	var particles := GPUParticles3D.new()
	scene.add_child(particles)
	var with: CulletPreview = world.preview(cam, size)
	check.call("particles are drawn always", with.counts().always == 1 and with.fate_of(particles) == "always" and with.explain(particles).contains("is drawn always: particles"))
	for node: Node in [sun, high, other, probe, particles]:
		node.free()
	world.cull_now()
