@tool
extends RefCounted
# Lines over the edited scene. They are instances of the server and no nodes, so that no scene holds them, and lie in the layer of the
# editor's own tools, which no camera of a scene shows.

const LAYER := 1 << 24

var instances: Array[RID] = []
# The server does not keep them.
var kept: Array[Resource] = []

# To be called before it goes.
func clear() -> void:
	for instance in instances:
		RenderingServer.free_rid(instance)
	instances.clear()
	kept.clear()

# Adds lines between pairs of `points`; `is_through` draws them over everything.
func add(points: PackedVector3Array, colour: Color, scenario: RID, is_through := false) -> void:
	if points.is_empty():
		return
	var arrays := []
	arrays.resize(Mesh.ARRAY_MAX)
	arrays[Mesh.ARRAY_VERTEX] = points
	var mesh := ArrayMesh.new()
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_LINES, arrays)
	var material := StandardMaterial3D.new()
	material.shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
	material.disable_fog = true
	material.no_depth_test = is_through
	material.albedo_color = colour
	mesh.surface_set_material(0, material)
	var instance := RenderingServer.instance_create2(mesh.get_rid(), scenario)
	RenderingServer.instance_set_layer_mask(instance, LAYER)
	RenderingServer.instance_geometry_set_cast_shadows_setting(instance, RenderingServer.SHADOW_CASTING_SETTING_OFF)
	instances.append(instance)
	kept.append_array([mesh, material])

# Returns the ends of the edges of a box around a node, in world space.
static func edges(node: VisualInstance3D) -> PackedVector3Array:
	var points := PackedVector3Array()
	var box := node.get_aabb()
	for i in 8:
		for axis: int in [1, 2, 4]:
			if not i & axis:
				points.append(node.global_transform * box.get_endpoint(i))
				points.append(node.global_transform * box.get_endpoint(i | axis))
	return points
