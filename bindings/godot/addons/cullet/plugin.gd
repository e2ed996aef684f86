@tool
extends EditorPlugin
# Adds the dock. Nothing here names a class of the extension, so that it loads without the library.

const Content := preload("dock.gd")

var dock: EditorDock
var content: Control

func _enter_tree() -> void:
	content = Content.new()
	dock = EditorDock.new()
	dock.title = "Cullet"
	dock.default_slot = EditorDock.DOCK_SLOT_RIGHT_UL
	dock.dock_icon = load("res://addons/cullet/icon.svg") if ResourceLoader.exists("res://addons/cullet/icon.svg") else null
	dock.add_child(content)
	add_dock(dock)
	scene_changed.connect(content.scene_changed)
	scene_closed.connect(content.scene_closed)
	EditorInterface.get_selection().selection_changed.connect(content.refresh)
	content.undo = get_undo_redo()
	content.bake.undo = get_undo_redo()
	content.library_message(get_plugin_version())

func _exit_tree() -> void:
	EditorInterface.get_selection().selection_changed.disconnect(content.refresh)
	content.clear()
	remove_dock(dock)
	dock.queue_free()
