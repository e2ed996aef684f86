@tool
extends RefCounted
# Writes the open scene as glTF, and has the program `cullet` make a report of what a camera sees of it.

const FOLDER := "user://cullet"
const SETTING := "cullet/program"

var pid := -1
var command := ""

# Makes the setting known to the editor's settings.
static func add_setting() -> void:
	var settings := EditorInterface.get_editor_settings()
	if not settings.has_setting(SETTING):
		settings.set_setting(SETTING, "")
	settings.set_initial_value(SETTING, "", false)
	settings.add_property_info({"name": SETTING, "type": TYPE_STRING, "hint": PROPERTY_HINT_GLOBAL_FILE})

# Returns the path of the program: the one of the settings, or else the first in PATH; empty where there is none.
static func program() -> String:
	var named := str(EditorInterface.get_editor_settings().get_setting(SETTING))
	if named != "":
		return named if FileAccess.file_exists(named) else ""
	var is_windows := OS.get_name() == "Windows"
	for folder in OS.get_environment("PATH").split(";" if is_windows else ":", false):
		var path := folder.path_join("cullet.exe" if is_windows else "cullet")
		if FileAccess.file_exists(path):
			return path
	return ""

# Begins a report of `root` as `camera` sees it in `pixels`. Returns what to tell the user.
func start(root: Node, camera: Camera3D, pixels: Vector2i) -> String:
	if camera.projection != Camera3D.PROJECTION_PERSPECTIVE:
		return "cullet report draws perspective cameras alone: choose another camera, or switch this view to perspective."
	var path := program()
	if path == "":
		return "The program cullet was not found: neither by the editor setting %s nor in PATH. Build it with `cargo build --release` in cullet's folder, and set %s to its target/release/cullet." % [SETTING, SETTING]
	var folder := ProjectSettings.globalize_path(FOLDER)
	DirAccess.make_dir_recursive_absolute(folder)
	var gltf := GLTFDocument.new()
	var state := GLTFState.new()
	var code := gltf.append_from_scene(root, state)
	if code == OK:
		code = gltf.write_to_filesystem(state, folder.path_join("scene.glb"))
	if code != OK:
		return "Godot could not write the scene as glTF to %s: %s." % [folder, error_string(code)]
	var file := FileAccess.open(folder.path_join("cameras.json"), FileAccess.WRITE)
	if not file:
		return "%s cannot be written: %s." % [folder, error_string(FileAccess.get_open_error())]
	file.store_string(JSON.stringify(cameras(camera, pixels)))
	file.close()
	var arguments := [
		"report", folder.path_join("scene.glb"), "--path", "file:" + folder.path_join("cameras.json"), "--views", "1",
		"--size", "%dx%d" % [pixels.x, pixels.y], "--out", folder.path_join("report"),
	]
	command = path + " " + " ".join(arguments)
	pid = OS.create_process(path, arguments)
	if pid < 0:
		return "%s could not be started." % path
	return "cullet report is running ..."

static func cameras(camera: Camera3D, pixels: Vector2i) -> Dictionary:
	var fov := camera.fov
	if camera.keep_aspect == Camera3D.KEEP_WIDTH:
		fov = rad_to_deg(2.0 * atan(tan(deg_to_rad(fov) * 0.5) * pixels.y / pixels.x))
	var at := camera.get_camera_transform()
	var view := {
		"eye": [at.origin.x, at.origin.y, at.origin.z], "direction": [-at.basis.z.x, -at.basis.z.y, -at.basis.z.z],
		"up": [at.basis.y.x, at.basis.y.y, at.basis.y.z], "near": camera.near, "far": camera.far,
	}
	return {"fov_degrees": fov, "views": [view]}

# Returns what to tell the user once the program has ended; empty before that.
func poll(opens: bool) -> String:
	if pid < 0 or OS.is_process_running(pid):
		return ""
	var code := OS.get_process_exit_code(pid)
	pid = -1
	var page := ProjectSettings.globalize_path(FOLDER).path_join("report/index.html")
	if code != 0 or not FileAccess.file_exists(page):
		return "cullet report ended with code %d. To see why, run: %s" % [code, command]
	if opens:
		OS.shell_open(page)
	return "The report is %s." % page
