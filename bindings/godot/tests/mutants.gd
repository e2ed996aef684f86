class_name Mutants
extends RefCounted
# Breaks what a culler must do, after it did it: pictures that stay the same then could not find a fault.

var case: Case
var kind := ""
var hidden: Array[RID] = []
var is_at_rest := false

func _init(case_: Case, kind_: String) -> void:
	case = case_
	kind = kind_
	if kind:
		RenderingServer.frame_pre_draw.connect(harm)

func harm() -> void:
	if is_at_rest:
		is_at_rest = false
		return
	for node in case.call("victims_of_" + kind):
		var rid: RID = node.get_instance()
		RenderingServer.instance_set_layer_mask(rid, 0)
		hidden.append(rid)

func rest() -> void:
	is_at_rest = kind != ""
	for rid in hidden:
		RenderingServer.instance_set_layer_mask(rid, 1)
	hidden.clear()

func end() -> void:
	rest()
	if kind:
		RenderingServer.frame_pre_draw.disconnect(harm)
