class_name Rooms
# Rooms of eight metres with a door in each wall, closed by thick walls, a floor and a roof; small things in each room.

const SIDE := 8.0
const HIGH := 3.0
const THICK := 0.4

static func build(parent: Node, count: int, things: int) -> Node3D:
	var rng := RandomNumberGenerator.new()
	rng.seed = 11
	var root := Node3D.new()
	root.name = "Rooms"
	parent.add_child(root)
	var half := count * SIDE * 0.5
	for i in count + 1:
		for k in count:
			for along_x: bool in [true, false]:
				# Every other wall has its door in another place, and those around all have none.
				var is_outer := i == 0 or i == count
				var from := k * SIDE - half
				var door := from + (2.0 if (i + k) % 2 else 5.0)
				if is_outer:
					wall(root, "w%d_%d_%d" % [i, k, int(along_x)], along_x, from, from + SIDE, i * SIDE - half, 0.0, HIGH)
				else:
					wall(root, "a%d_%d_%d" % [i, k, int(along_x)], along_x, from, door - 0.6, i * SIDE - half, 0.0, HIGH)
					wall(root, "b%d_%d_%d" % [i, k, int(along_x)], along_x, door + 0.6, from + SIDE, i * SIDE - half, 0.0, HIGH)
					wall(root, "c%d_%d_%d" % [i, k, int(along_x)], along_x, door - 0.6, door + 0.6, i * SIDE - half, 2.1, HIGH)
	var whole := count * SIDE + THICK * 2
	box(root, "floor", Vector3(0, -THICK * 0.5, 0), Vector3(whole, THICK, whole), Color.DIM_GRAY)
	box(root, "roof", Vector3(0, HIGH + THICK * 0.5, 0), Vector3(whole, THICK, whole), Color.GRAY)
	for x in count:
		for z in count:
			for i in things:
				var at := Vector3(rng.randf_range(1, SIDE - 1), 0, rng.randf_range(1, SIDE - 1)) + Vector3(x * SIDE - half, 0, z * SIDE - half)
				var size := rng.randf_range(0.2, 0.7)
				var thing := box(root, "t%d_%d_%d" % [x, z, i], at + Vector3.UP * size * 0.5, Vector3.ONE * size, Color.from_hsv(rng.randf(), 0.6, 0.9))
				thing.add_to_group("thing")
	return root

# A wall along x or z, from and to along it, a little longer so that corners are closed.
static func wall(root: Node, name: String, along_x: bool, from: float, to: float, across: float, low: float, high: float) -> void:
	var is_whole := low == 0.0
	var long := to - from + (THICK if is_whole else 0.0)
	var middle := (from + to) * 0.5
	# Ends at doors are where the door begins.
	if name[0] == "a":
		long -= THICK * 0.5
		middle -= THICK * 0.25
	if name[0] == "b":
		long -= THICK * 0.5
		middle += THICK * 0.25
	# Overlaps with the floor and the roof.
	var bottom := low - 0.1 if is_whole else low
	var at := Vector3(middle, (bottom + high + 0.1) * 0.5, across)
	var size := Vector3(long, high + 0.1 - bottom, THICK)
	if not along_x:
		at = Vector3(at.z, at.y, at.x)
		size = Vector3(size.z, size.y, size.x)
	box(root, name, at, size, Color.SANDY_BROWN)

static func box(root: Node, name: String, at: Vector3, size: Vector3, colour: Color) -> MeshInstance3D:
	var node := MeshInstance3D.new()
	node.name = name
	node.mesh = BoxMesh.new()
	node.mesh.size = size
	node.position = at
	var material := StandardMaterial3D.new()
	material.albedo_color = colour
	node.material_override = material
	root.add_child(node)
	return node

static func bake(world: CulletWorld, root: Node, set_up: Callable = Callable()) -> CulletPvs:
	var baker := CulletPvsBaker.new()
	if set_up.is_valid():
		set_up.call(baker)
	if not baker.start(world, root):
		return null
	while baker.is_running():
		await root.get_tree().process_frame
		OS.delay_msec(5)
	var ended := baker.get_error()
	if ended:
		print("  bake: ", ended)
	return baker.get_result()
