extends Case
# A skinned mesh and one with blend shapes, which leave the boxes they have at rest.

var skeleton: Skeleton3D
var blend: MeshInstance3D

func build() -> void:
	ground()
	wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	skeleton = Skeleton3D.new()
	skeleton.add_bone("root")
	add_child(skeleton)
	skeleton.position = Vector3(0, 1, -15)
	var arrays := BoxMesh.new().get_mesh_arrays()
	var count: int = arrays[Mesh.ARRAY_VERTEX].size()
	var bones := PackedInt32Array()
	bones.resize(count * 4)
	var weights := PackedFloat32Array()
	weights.resize(count * 4)
	for i in count:
		weights[i * 4] = 1.0
	arrays[Mesh.ARRAY_BONES] = bones
	arrays[Mesh.ARRAY_WEIGHTS] = weights
	var skinned := MeshInstance3D.new()
	var made := ArrayMesh.new()
	made.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
	skinned.mesh = made
	skeleton.add_child(skinned)
	skinned.skeleton = NodePath("..")
	var plain := BoxMesh.new().get_mesh_arrays()
	var shapes := []
	shapes.resize(3)
	var high := PackedVector3Array()
	for p in plain[Mesh.ARRAY_VERTEX]:
		high.append(p + Vector3(0, 9, 0))
	shapes[0] = high
	shapes[1] = plain[Mesh.ARRAY_NORMAL]
	shapes[2] = plain[Mesh.ARRAY_TANGENT]
	var morph := ArrayMesh.new()
	morph.add_blend_shape("high")
	morph.blend_shape_mode = Mesh.BLEND_SHAPE_MODE_NORMALIZED
	morph.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, plain, [shapes])
	blend = MeshInstance3D.new()
	blend.mesh = morph
	blend.position = Vector3(3, 1, -15)
	add_child(blend)
	sun()
	camera(Vector3(0, 1.7, 2))

func frames() -> int:
	return 2

func step(i: int) -> void:
	skeleton.set_bone_pose_position(0, Vector3(-4.0 + i, 3.0 * (i % 4), 0))
	blend.set_blend_shape_value(0, 0.2 * i)
