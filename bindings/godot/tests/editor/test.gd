@tool
extends EditorPlugin
# godot --headless --editor --path . -- editor-test: opens scenes in the editor and works the dock. Without the library, only that
# the dock says so. With EDITOR_SHOT=FILE.png it saves a picture of the editor instead.

var failed := 0
var dock: Control

func check(what: String, is_right: bool) -> void:
	print("ok " if is_right else "FAILED ", what)
	failed += 0 if is_right else 1

func _enter_tree() -> void:
	if OS.get_cmdline_user_args().has("editor-test"):
		run.call_deferred()

func run() -> void:
	while EditorInterface.get_resource_filesystem().is_scanning():
		await frames(1)
	await frames(5)
	var found := get_tree().root.find_children("Cullet", "ScrollContainer", true, false)
	check("the dock is there", found.size() == 1)
	dock = found[0] if found else null
	if dock and OS.has_environment("EDITOR_SHOT"):
		await shoot(OS.get_environment("EDITOR_SHOT"))
	elif dock and ClassDB.class_exists("CulletWorld"):
		await with_library()
	elif dock:
		check("without the library the dock says so, and nothing else", dock.message.text.contains("is not loaded") and not dock.body.visible and not dock.add_world.visible)
	print("%d failed" % failed)
	get_tree().quit(1 if failed else 0)

func frames(count: int) -> void:
	for i in count:
		await get_tree().process_frame

func open(path: String) -> Node:
	EditorInterface.open_scene_from_path(path)
	await frames(3)
	return EditorInterface.get_edited_scene_root()

func save(root: Node, path: String) -> void:
	for node in root.find_children("*", "", true, false):
		node.owner = root
	var packed := PackedScene.new()
	packed.pack(root)
	ResourceSaver.save(packed, path)
	root.free()

func city() -> void:
	var root := Node3D.new()
	root.name = "City"
	load("res://city.gd").build(root, 6, 8)
	for node: MeshInstance3D in root.get_children():
		node.name = "House%d" % node.get_index() if node.scale.y > 2 else "Crate%d" % node.get_index()
		# So that the colours of the lines stand out.
		var material := StandardMaterial3D.new()
		material.albedo_color = Color(0.35, 0.36, 0.38) if node.scale.y != 1 else Color(0.12, 0.13, 0.14)
		node.material_override = material
	root.get_child(-1).name = "Ground"
	var camera := Camera3D.new()
	camera.name = "Eye"
	camera.position = Vector3(-4, 1.7, 60)
	root.add_child(camera)
	save(root, "res://city.tscn")
	var empty := Node3D.new()
	empty.name = "Empty"
	save(empty, "res://empty.tscn")

func with_library() -> void:
	check("library and dock are of one version", dock.get_meta("library") == "")
	check("a dock of another version says so", dock.library_message("0.0.1").contains("version 0.0.1") and dock.message.visible and not dock.body.visible)
	dock.library_message(str(ClassDB.class_call_static("CulletWorld", "version")))
	city()
	var root: Node = await open("res://city.tscn")
	check("a scene without a CulletWorld is offered one", dock.add_world.visible and not dock.body.visible)
	dock.add_world.pressed.emit()
	await frames(2)
	var world: Node = root.get_node_or_null("CulletWorld")
	check("it is added to the scene, and can be used", world != null and world.owner == root and dock.body.visible)
	var history: UndoRedo = get_undo_redo().get_history_undo_redo(get_undo_redo().get_object_history_id(root))
	history.undo()
	await frames(2)
	check("and taken away by undo", not root.has_node("CulletWorld") and dock.add_world.visible)
	history.redo()
	await frames(2)
	decisions(root)
	await movement(root)
	selection(root)
	reports()
	var other: Node = await open("res://empty.tscn")
	check("in another scene the decision is forgotten", other.name == "Empty" and dock.decision == null and dock.overlay.instances.is_empty())
	root = await open("res://city.tscn")
	check("and the first scene can be decided about again", choose(root) and dock.decision.counts().nodes > 100)
	dock.forget()
	await bakes()

# Chooses the scene's own camera, and switches the preview on.
func choose(root: Node) -> bool:
	dock.list_cameras()
	for i in dock.camera_choice.item_count:
		if dock.camera_choice.get_item_text(i) == "Eye":
			dock.camera_choice.select(i)
	dock.live.button_pressed = true
	dock.thaw()
	return dock.camera_now() == root.get_node("Eye") and dock.decision != null

func decisions(root: Node) -> void:
	var before := root.find_children("*", "", true, false).size()
	check("the scene's camera can be chosen", choose(root))
	var n: Dictionary = dock.decision.counts()
	check("nodes are drawn, outside of the picture, and hidden", n.drawn > 5 and n.frustum > 50 and n.occlusion > 50 and n.drawn + n.frustum + n.occlusion == n.nodes)
	check("the list says so", dock.rows.occlusion.count.text == str(n.occlusion) and dock.rows.drawn.bar.value == n.drawn)
	check("and their bounds are shown, and the frustum", dock.overlay.instances.size() == 3)
	check("and the map, but for what is not asked for", dock.map.rects.has("drawn") and dock.map.rects.occlusion.size() == n.occlusion and not dock.map.rects.has("frustum"))
	check("nothing is added to the scene", root.find_children("*", "", true, false).size() == before and root.get_child(0).get_child_count(true) == 0)
	var packed := PackedScene.new()
	packed.pack(root)
	var twin := root.get_child(0).duplicate()
	check("nor would anything be saved or copied with it", packed.get_state().get_connection_count() == 0 and twin.get_child_count(true) == 0 and twin.get_signal_connection_list("property_list_changed").is_empty())
	twin.free()
	var mark: Node = ClassDB.instantiate("NoCulletOccluder")
	root.add_child(mark)
	dock.decide()
	check("marks count in the editor", dock.decision.counts().occlusion == 0)
	mark.free()
	dock.decide()
	check("and are gone with the node", dock.decision.counts() == n)
	dock.rows.frustum.check.button_pressed = true
	check("what is outside can be shown too", dock.overlay.instances.size() == 4)
	dock.rows.frustum.check.button_pressed = false
	dock.camera_choice.select(0)
	dock.thaw()
	check("the editor's own view is decided about", dock.decision != null and dock.decision.counts().nodes == n.nodes)

func movement(root: Node) -> void:
	choose(root)
	var eye: Camera3D = root.get_node("Eye")
	var n: Dictionary = dock.decision.counts()
	dock.get_parent().make_visible()
	await frames(1)
	var after := func(turned: float) -> Dictionary:
		eye.rotation.y = turned
		dock._process(0.5)
		return dock.decision.counts()
	check("the preview follows the camera", dock.is_visible_in_tree() and after.call(PI) != n and after.call(0.0) == n)
	dock.frozen.button_pressed = true
	check("frozen, the decision stays", after.call(PI) == n)
	dock.frozen.button_pressed = false
	check("thawed, it is another", after.call(PI) != n)
	check("and back there the first", after.call(0.0) == n)
	var crate := MeshInstance3D.new()
	crate.mesh = BoxMesh.new()
	crate.name = "Crate"
	root.add_child(crate)
	crate.position = eye.position + Vector3(0, 0, -3)
	dock.decide()
	check("a node that came is decided about", dock.decision.fate_of(crate) == "drawn")
	crate.position = eye.position + Vector3(0, 0, 9)
	dock.decide()
	check("and where it went", dock.decision.fate_of(crate) == "frustum")
	crate.free()
	dock.decide()
	check("and it leaves", dock.decision.counts() == n)

func selection(root: Node) -> void:
	var hidden: Node3D = null
	for node in root.get_children():
		if node is MeshInstance3D and dock.decision.fate_of(node) == "occlusion":
			hidden = node
	var selected := EditorInterface.get_selection()
	selected.clear()
	selected.add_node(hidden)
	dock.show_selection()
	check("the selected node is explained", dock.why.text.contains("%s is not drawn: it lies behind " % hidden.name))
	check("its bounds and those of what hides it are shown", dock.of_selection.instances.size() > 1)
	selected.clear()
	selected.add_node(root.get_node("Eye"))
	dock.show_selection()
	check("a camera is left to Godot", dock.why.text.contains("left to Godot"))

func reports() -> void:
	var settings := EditorInterface.get_editor_settings()
	settings.set_setting("cullet/program", "/nowhere/cullet")
	dock.report_button.pressed.emit()
	check("without the program the dock says what to do", dock.report_message.text.contains("was not found") and not dock.report_button.disabled)
	check("a program that writes a page is run", ended("mkdir -p \"${10}\"; test -s \"$2\" && grep -q eye \"${4#file:}\" && echo page > \"${10}/index.html\"").contains("The report is"))
	check("one that fails is told of", ended("exit 3").contains("ended with code 3"))
	settings.set_setting("cullet/program", "")

# Rooms are baked by the dock, and what they hide is told by the preview.
func bakes() -> void:
	var made := Node3D.new()
	made.name = "Level"
	load("res://rooms.gd").build(made, 4, 4)
	var camera := Camera3D.new()
	camera.name = "Eye"
	camera.position = Vector3(-12, 1.6, -12)
	camera.rotation.y = -0.75 * PI
	made.add_child(camera)
	var own: Node = ClassDB.instantiate("CulletWorld")
	own.name = "CulletWorld"
	own.occlusion = false
	made.add_child(own)
	save(made, "res://level.tscn")
	var root: Node = await open("res://level.tscn")
	var before := root.find_children("*", "", true, false).size()
	var world: Node = root.get_node("CulletWorld")
	var bake: Node = dock.bake
	DirAccess.remove_absolute("res://level.cullet_pvs.res")
	bake.button.pressed.emit()
	check("a bake begins", bake.is_running() and bake.bar.visible and bake.button.text.contains("Cancel"))
	await frames(2)
	bake.button.pressed.emit()
	await frames(2)
	check("and is cancelled: nothing is kept", not bake.is_running() and bake.message.text.contains("cancelled") and world.pvs.is_empty() and not FileAccess.file_exists("res://level.cullet_pvs.res"))
	bake.button.pressed.emit()
	for i in 3000:
		if not bake.is_running():
			break
		OS.delay_msec(10)
		await frames(1)
	await frames(2)
	check("it ends with a file beside the scene", FileAccess.file_exists("res://level.cullet_pvs.res") and bake.message.text.contains("Nothing that can be seen is missing"))
	check("which the CulletWorld has", world.pvs.size() == 1 and world.pvs[0].resource_path == "res://level.cullet_pvs.res")
	check("nothing else is added to the scene", root.find_children("*", "", true, false).size() == before)
	check("the preview knows it", choose(root) and dock.decision.counts().pvs > 10 and dock.rows.pvs.row.visible)
	var hidden: Node3D = null
	for node in root.find_children("*", "MeshInstance3D", true, false):
		if dock.decision.fate_of(node) == "pvs":
			hidden = node
	check("and why", hidden != null and dock.decision.explain(hidden).contains("baked sets"))
	var history: UndoRedo = get_undo_redo().get_history_undo_redo(get_undo_redo().get_object_history_id(root))
	history.undo()
	check("it can be undone", world.pvs.is_empty())
	dock.forget()

# Runs a script in place of the program, and returns what the dock says in the end.
func ended(script: String) -> String:
	var path := ProjectSettings.globalize_path("user://program.sh")
	var file := FileAccess.open(path, FileAccess.WRITE)
	file.store_string("#!/bin/sh\n%s\n" % script)
	file.close()
	OS.execute("chmod", ["+x", path])
	EditorInterface.get_editor_settings().set_setting("cullet/program", path)
	dock.report_button.pressed.emit()
	for i in 200:
		OS.delay_msec(20)
		dock._process(0.0)
		if not dock.report_button.disabled:
			break
	return dock.report_message.text

# A frozen decision of a camera in a street, seen from above.
func shoot(path: String) -> void:
	city()
	DisplayServer.window_set_size(Vector2i(1280, 800))
	var root: Node = await open("res://city.tscn")
	EditorInterface.set_main_screen_editor("3D")
	dock.add_culler()
	dock.get_parent().make_visible()
	await frames(10)
	choose(root)
	dock.frozen.button_pressed = true
	dock.show_decision()
	selection(root)
	var tower: Node = root.get_child(0)
	for node in root.get_children():
		if node is MeshInstance3D and dock.decision.fate_of(node) == "occlusion" and node.scale.y > tower.scale.y:
			tower = node
	EditorInterface.get_selection().clear()
	EditorInterface.get_selection().add_node(tower)
	var above := EditorInterface.get_editor_viewport_3d(0).get_camera_3d()
	for i in 90:
		above.look_at_from_position(Vector3(70, 130, 130), Vector3(0, 0, 10))
		await RenderingServer.frame_post_draw
	get_tree().root.get_texture().get_image().save_png(path)
