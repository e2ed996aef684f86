@tool
extends ScrollContainer
# The dock: what a camera would draw of the edited scene, and why. Nothing is hidden, and nothing of the scene is changed.

const Fates := preload("fates.gd")
const Overlay := preload("overlay.gd")
const Map := preload("map.gd")
const Report := preload("report.gd")
const Bake := preload("bake.gd")

# Seconds between decisions while the camera moves, and while it stands.
const SOON := 0.2
const LATER := 1.0

var undo: EditorUndoRedoManager
var decision: RefCounted
var overlay := Overlay.new()
var of_selection := Overlay.new()
var report := Report.new()
var age := 0.0
var place := Transform3D()

var message := Label.new()
var add_world := Button.new()
var body := VBoxContainer.new()
var camera_choice := OptionButton.new()
var live := CheckButton.new()
var frozen := CheckButton.new()
var rows := {}
var counts := Label.new()
var map := Map.new()
var why := Label.new()
var report_button := Button.new()
var report_message := Label.new()
var bake := Bake.new()

func _init() -> void:
	name = "Cullet"
	horizontal_scroll_mode = SCROLL_MODE_DISABLED
	size_flags_vertical = SIZE_EXPAND_FILL
	var all := VBoxContainer.new()
	all.size_flags_horizontal = SIZE_EXPAND_FILL
	add_child(all)
	for label: Label in [message, counts, why, report_message]:
		label.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	all.add_child(message)
	button(all, add_world, "Add a CulletWorld", "Adds the node that culls the scene when it runs.", add_culler)
	all.add_child(body)
	body.add_child(camera_choice)
	camera_choice.tooltip_text = "The camera whose picture is decided about."
	camera_choice.get_popup().about_to_popup.connect(list_cameras)
	camera_choice.item_selected.connect(func(_i: int) -> void: thaw())
	button(body, live, "Preview", "Decides what the camera would draw, again and again. Nothing is hidden.", func() -> void: thaw())
	button(body, frozen, "Freeze", "Keeps the decision while the camera flies on, to look at it from elsewhere.", func() -> void: show_decision())
	for fate in Fates.ALL:
		add_row(fate)
	body.add_child(counts)
	body.add_child(map)
	why.tooltip_text = "Why the selected node is drawn or not. White lines: its bounds; pink lines: the nodes that hide it."
	why.mouse_filter = MOUSE_FILTER_STOP
	body.add_child(why)
	button(body, report_button, "Report of this scene", "Writes the scene as glTF, has the program cullet cull and draw it from this camera, and opens the page.", start_report)
	body.add_child(report_message)
	bake.find_world = find_world
	body.add_child(bake)
	list_cameras()

func button(parent: Node, what: BaseButton, text: String, tooltip: String, pressed: Callable) -> void:
	what.set("text", text)
	what.tooltip_text = tooltip
	what.pressed.connect(pressed)
	parent.add_child(what)

# A row of the funnel: how many nodes, a bar, and whether their bounds are drawn.
func add_row(fate: String) -> void:
	var row := HBoxContainer.new()
	var check := CheckBox.new()
	check.text = Fates.NAMES[fate]
	check.tooltip_text = "Show the bounds of these nodes in the 3D view and on the map."
	check.button_pressed = fate in ["pvs", "occlusion", "drawn"]
	check.toggled.connect(func(_on: bool) -> void: show_decision())
	check.size_flags_horizontal = SIZE_EXPAND_FILL
	check.add_theme_color_override("font_color", Fates.COLOURS[fate])
	check.add_theme_color_override("font_pressed_color", Fates.COLOURS[fate])
	var bar := ProgressBar.new()
	bar.show_percentage = false
	bar.custom_minimum_size = Vector2(60, 8)
	bar.size_flags_vertical = SIZE_SHRINK_CENTER
	var fill := StyleBoxFlat.new()
	fill.bg_color = Fates.COLOURS[fate]
	bar.add_theme_stylebox_override("fill", fill)
	var count := Label.new()
	count.custom_minimum_size = Vector2(48, 0)
	count.horizontal_alignment = HORIZONTAL_ALIGNMENT_RIGHT
	for part: Control in [check, bar, count]:
		row.add_child(part)
	body.add_child(row)
	rows[fate] = {"row": row, "check": check, "bar": bar, "count": count}

func _ready() -> void:
	Report.add_setting()
	refresh()

func _process(delta: float) -> void:
	var told := report.poll(DisplayServer.get_name() != "headless")
	if told != "":
		report_message.text = told
		report_button.disabled = false
	age += delta
	if not live.button_pressed or frozen.button_pressed or age < SOON or not is_visible_in_tree():
		return
	var camera := camera_now()
	if camera and (age >= LATER or camera.global_transform != place):
		decide()

# Says what is wrong with the library; empty where nothing is.
func library_message(version: String) -> String:
	var text := ""
	if not ClassDB.class_exists("CulletWorld"):
		text = "The library of cullet is not loaded. The output panel says why; put the file that addons/cullet/cullet.gdextension names for this system into addons/cullet/bin, and start the editor again."
	elif not ClassDB.class_has_method("CulletWorld", "preview"):
		text = "The library of cullet in addons/cullet/bin is older than this dock. Copy all of addons/cullet from one release, and start the editor again."
	else:
		var own := str(ClassDB.class_call_static("CulletWorld", "version"))
		if own != version:
			text = "The library of cullet is version %s and this dock is version %s. Copy all of addons/cullet from one release, and start the editor again." % [own, version]
	set_meta("library", text)
	refresh()
	return text

func scene_changed(_root: Node) -> void:
	forget()
	list_cameras()
	refresh()

func scene_closed(_path: String) -> void:
	scene_changed(null)

# Shows what can be done with the scene that is open.
func refresh() -> void:
	var library := str(get_meta("library", ""))
	var root := EditorInterface.get_edited_scene_root()
	var has_world := library == "" and find_world() != null
	message.text = library
	if library == "" and not has_world:
		message.text = "The scene has no CulletWorld, so that nothing of it is culled." if root else "No scene is open."
	message.visible = message.text != ""
	add_world.visible = library == "" and root != null and not has_world
	body.visible = has_world
	show_selection()

# Returns the node that culls the edited scene.
func find_world() -> Node:
	var root := EditorInterface.get_edited_scene_root()
	if not root or not ClassDB.class_exists("CulletWorld"):
		return null
	if root.is_class("CulletWorld"):
		return root
	var all := root.find_children("*", "CulletWorld", true, false)
	return all[0] if all else null

func add_culler() -> void:
	var root := EditorInterface.get_edited_scene_root()
	var world: Node = ClassDB.instantiate("CulletWorld")
	world.name = "CulletWorld"
	undo.create_action("Add a CulletWorld", UndoRedo.MERGE_DISABLE, root)
	undo.add_do_method(root, "add_child", world, true)
	undo.add_do_property(world, "owner", root)
	undo.add_do_reference(world)
	undo.add_do_method(self, "refresh")
	undo.add_undo_method(self, "forget")
	undo.add_undo_method(root, "remove_child", world)
	undo.add_undo_method(self, "refresh")
	undo.commit_action()

# Lists the editor's view and the cameras of the scene, and keeps the choice.
func list_cameras() -> void:
	var chosen: Variant = camera_choice.get_selected_metadata() if camera_choice.selected >= 0 else 0
	camera_choice.clear()
	camera_choice.add_item("The editor's view")
	camera_choice.set_item_metadata(0, 0)
	var root := EditorInterface.get_edited_scene_root()
	for camera in root.find_children("*", "Camera3D", true, false) if root else []:
		camera_choice.add_item(str(root.get_path_to(camera)))
		camera_choice.set_item_metadata(-1, camera.get_instance_id())
		if camera.get_instance_id() == chosen:
			camera_choice.select(camera_choice.item_count - 1)

# Returns the camera that is decided about, null where it is gone.
func camera_now() -> Camera3D:
	var id: int = camera_choice.get_selected_metadata() if camera_choice.selected >= 0 else 0
	if id == 0:
		return EditorInterface.get_editor_viewport_3d(0).get_camera_3d()
	var camera := instance_from_id(id) as Camera3D
	return camera if camera and camera.is_inside_tree() else null

# Returns the pixels of that camera's picture: those of the editor's view, or of the project's window.
func pixels() -> Vector2i:
	if camera_choice.get_selected_metadata() == 0:
		return EditorInterface.get_editor_viewport_3d(0).size
	var setting := "display/window/size/viewport_%s"
	return Vector2i(ProjectSettings.get_setting(setting % "width"), ProjectSettings.get_setting(setting % "height"))

# Decides anew from where the camera is.
func thaw() -> void:
	frozen.set_pressed_no_signal(false)
	if live.button_pressed:
		decide()
	else:
		forget()

func decide() -> void:
	var world := find_world()
	var camera := camera_now()
	decision = world.call("preview", camera, pixels()) if world and camera else null
	age = 0.0
	place = camera.global_transform if camera else Transform3D()
	if not world:
		refresh()
	show_decision()

# Forgets the decision, and all that shows it.
func forget() -> void:
	decision = null
	live.set_pressed_no_signal(false)
	frozen.set_pressed_no_signal(false)
	show_decision()

# Takes all lines away.
func clear() -> void:
	bake.stop()
	decision = null
	overlay.clear()
	of_selection.clear()

func show_decision() -> void:
	overlay.clear()
	var numbers: Dictionary = decision.counts() if decision else {}
	var shown := []
	for fate: String in Fates.ALL:
		var number: int = numbers.get(fate, 0)
		rows[fate].row.visible = decision != null and (number > 0 or fate in ["frustum", "occlusion", "drawn"])
		rows[fate].bar.max_value = maxi(numbers.get("nodes", 0), 1)
		rows[fate].bar.value = number
		rows[fate].count.text = str(number)
		if rows[fate].check.button_pressed:
			shown.append(fate)
	counts.text = ""
	map.visible = decision != null
	if decision:
		var is_seen := "%d of %d nodes are drawn; %d nodes hide others. Not drawn: %d stay in shadow maps, %d are left out of them too. Lamps left out: %d."
		var drawn: int = numbers.drawn + numbers.always + numbers.probe
		counts.text = is_seen % [drawn, numbers.nodes, numbers.occluders, numbers.shadow_only, numbers.casters, numbers.dark_lamps]
		var scenario := scenario_now()
		for fate: String in shown:
			overlay.add(decision.lines(fate), Fates.COLOURS[fate], scenario)
		if frozen.button_pressed or camera_choice.get_selected_metadata() != 0:
			overlay.add(decision.frustum(1e4), Color.WHITE, scenario)
	map.show_decision(decision, shown)
	show_selection()

func scenario_now() -> RID:
	return EditorInterface.get_editor_viewport_3d(0).find_world_3d().scenario

# Says why the selected node is drawn, and shows what hides it.
func show_selection() -> void:
	of_selection.clear()
	why.text = ""
	if not decision or not find_world():
		return
	var selected := EditorInterface.get_selection().get_selected_nodes().filter(func(node: Node) -> bool: return node is Node3D)
	if selected.is_empty():
		why.text = "Select a node to read why it is drawn or not."
		return
	var node: Node3D = selected[0]
	why.text = decision.explain(node)
	var scenario := scenario_now()
	if node is VisualInstance3D:
		of_selection.add(Overlay.edges(node), Color.WHITE, scenario, true)
	for hider: Node3D in decision.hidden_by(node):
		if hider is VisualInstance3D:
			of_selection.add(Overlay.edges(hider), Color.HOT_PINK, scenario, true)

func start_report() -> void:
	var root := EditorInterface.get_edited_scene_root()
	var camera := camera_now()
	if not root or not camera:
		return
	report_message.text = report.start(root, camera, pixels())
	report_button.disabled = report.pid >= 0
