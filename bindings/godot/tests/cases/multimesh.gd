extends Case
# MultiMeshes that hide others and are hidden; their parts move, and so do they.

var nodes: Array[MultiMeshInstance3D] = []

func build() -> void:
	var box := BoxMesh.new()
	for k in 10:
		var multi := MultiMesh.new()
		multi.transform_format = MultiMesh.TRANSFORM_3D
		multi.mesh = box
		multi.instance_count = 8
		for i in 8:
			var size := Vector3(3.2, 6, 0.5) if k == 0 else Vector3.ONE
			var at := Vector3(i * 3.0 - 11, 3, -10) if k == 0 else Vector3(i * 1.5 + 6 * (k % 4) - 14, 1, -14.0 - k * 2)
			multi.set_instance_transform(i, Transform3D(Basis.from_scale(size), at))
		var node := MultiMeshInstance3D.new()
		node.multimesh = multi
		add_child(node)
		nodes.append(node)
	ground()
	sun(true)
	camera(Vector3(0, 1.7, 0))

func steps() -> int:
	return 10

func step(i: int) -> void:
	look_about(i % 5)
	match i:
		3:
			nodes[0].multimesh.set_instance_transform(3, Transform3D(Basis.from_scale(Vector3.ONE), Vector3(0, 9, -10)))
		4:
			nodes[0].multimesh.visible_instance_count = 5
		5:
			nodes[3].multimesh.set_instance_transform(0, Transform3D(Basis.IDENTITY, Vector3(0, 9, -15)))
		6:
			nodes[5].position.y += 8
		7:
			nodes[0].multimesh.visible_instance_count = -1
		8:
			nodes[0].position.y -= 4.5

func most_drawn() -> float:
	return 0.9
