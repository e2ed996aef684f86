@tool
extends VBoxContainer
# Bakes which nodes of the edited scene may be seen from where, saves that beside the scene, and puts it into its CulletWorld.

# In the order of the constants of CulletPvsBaker.
const METHODS := ["Rooms that are found, proved", "A grid of cells, proved", "A grid of cells, sampled: may flicker"]

var undo: EditorUndoRedoManager
# Returns the CulletWorld of the edited scene.
var find_world: Callable
var baker: RefCounted
var world: Node
var path := ""

var method := OptionButton.new()
var button := Button.new()
var bar := ProgressBar.new()
var message := Label.new()

func _init() -> void:
	for text: String in METHODS:
		method.add_item(text)
	method.tooltip_text = "Which cells cameras may be in, and whether what a cell hides is proved hidden. Scripts have more settings: CulletPvsBaker."
	method.fit_to_longest_item = false
	method.text_overrun_behavior = TextServer.OVERRUN_TRIM_ELLIPSIS
	button.pressed.connect(press)
	bar.max_value = 1.0
	message.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	for part: Control in [method, button, bar, message]:
		add_child(part)
	show_state()

func show_state() -> void:
	var runs := is_running()
	button.text = "Cancel the bake" if runs else "Bake visible sets"
	button.tooltip_text = "Nothing is kept of it." if runs else "Finds, on other threads, what each place of the scene can see, saves it beside the scene and gives it to the CulletWorld."
	method.disabled = runs
	bar.visible = runs

func is_running() -> bool:
	return baker != null and baker.is_running()

# Begins a bake, or ends the one that runs.
func press() -> void:
	if is_running():
		baker.cancel()
		return
	world = find_world.call()
	var root := EditorInterface.get_edited_scene_root()
	if not world or not root:
		message.text = "No scene with a CulletWorld is open."
		return
	path = (root.scene_file_path.get_basename() if root.scene_file_path != "" else "res://scene") + ".cullet_pvs.res"
	baker = ClassDB.instantiate("CulletPvsBaker")
	baker.method = method.selected
	baker.progressed.connect(func(share: float) -> void: bar.value = share)
	baker.finished.connect(end, CONNECT_DEFERRED)
	bar.value = 0.0
	message.text = "" if baker.start(world, root) else "The bake cannot begin: %s." % baker.get_error()
	show_state()

# Saves a result and gives it to the CulletWorld, in place of an earlier one of the scene.
func end(pvs: Resource) -> void:
	show_state()
	if not pvs:
		message.text = "Nothing was baked: %s." % baker.get_error()
		return
	var code := ResourceSaver.save(pvs, path)
	if code != OK:
		message.text = "%s cannot be written: %s." % [path, error_string(code)]
		return
	pvs.take_over_path(path)
	var cells: int = pvs.cell_count()
	message.text = "%d cells and %d nodes, saved as %s. " % [cells, pvs.node_count(), path]
	if pvs.is_exact():
		message.text += "Nothing that can be seen is missing."
	else:
		message.text += "About %.2f %% of what is seen from a cell is missing, up to %.2f %% in one." % [100.0 * pvs.missing().x, 100.0 * pvs.missing().y]
	if not is_instance_valid(world) or not world.is_inside_tree():
		message.text += " The scene was closed: put the file into its CulletWorld's `pvs`."
		return
	var before: Array = world.pvs
	var after: Array = before.duplicate()
	after.assign(before.filter(func(other: Resource) -> bool: return other != null and other.resource_path != path) + [pvs])
	undo.create_action("Bake visible sets", UndoRedo.MERGE_DISABLE, world)
	undo.add_do_property(world, "pvs", after)
	undo.add_undo_property(world, "pvs", before)
	undo.commit_action()

# Ends a bake with the editor or the scene.
func stop() -> void:
	if is_running():
		baker.cancel()
