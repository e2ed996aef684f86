extends "res://cases/changes.gd"
# The same changes, with a child at each node that reports them, and groups that move.

var group: Node3D

func build() -> void:
	super()
	group = Node3D.new()
	add_child(group)
	for i in 12:
		var house: MeshInstance3D = houses[i * 3]
		remove_child(house)
		group.add_child(house)

func step(i: int) -> void:
	world.follow = 2
	super(i)
	group.position.x += 2.0
	group.rotation.y += 0.1
	group.visible = i % 7 != 6
