class_name Case
extends Node3D
# A scene, and what happens in it. The runner draws each step without the culler and with it, in the first frame after the step.

var world: CulletWorld
var cameras: Array[Camera3D] = []
var rng := RandomNumberGenerator.new()

# Builds the scene, with at least one camera.
func build() -> void:
	pass

# Once, before the first step: the culler is off.
func begin() -> void:
	pass

func steps() -> int:
	return 6

# Changes the scene; the culler is on.
func step(_i: int) -> void:
	pass

# The largest share of the nodes that may be drawn, over all steps: a culler that keeps everything fails too.
func most_drawn() -> float:
	return 1.0

# Lamps that must be hidden in at least one step.
func least_dark() -> int:
	return 0

# Frames between a step and the pictures of it, for what Godot itself spreads over frames.
func frames() -> int:
	return 1

func viewports() -> Array:
	return [get_viewport()]

func camera(at: Vector3, turned := 0.0, parent: Node = self) -> Camera3D:
	var made := Camera3D.new()
	made.far = 500
	parent.add_child(made)
	made.position = at
	made.rotation.y = turned
	made.make_current()
	cameras.append(made)
	return made

func sun(shadow := false) -> DirectionalLight3D:
	var light := DirectionalLight3D.new()
	light.shadow_enabled = shadow
	light.rotation_degrees = Vector3(-40, 130, 0)
	add_child(light)
	return light

func mesh(what: Mesh, at: Vector3, size := Vector3.ONE, colour := Color.GRAY) -> MeshInstance3D:
	var node := MeshInstance3D.new()
	node.mesh = what
	node.transform = Transform3D(Basis.from_scale(size), at)
	var material := StandardMaterial3D.new()
	material.albedo_color = colour
	node.material_override = material
	add_child(node)
	return node

func wall(at: Vector3, size: Vector3, colour := Color.SANDY_BROWN) -> MeshInstance3D:
	return mesh(BoxMesh.new(), at, size, colour)

func ground(side := 200.0) -> MeshInstance3D:
	return wall(Vector3(0, -0.5, 0), Vector3(side, 1, side), Color.DARK_OLIVE_GREEN)

# Things behind a wall, as seen from the origin along -Z: most are hidden, some look over it and beside it.
func things_behind_a_wall(make: Callable) -> void:
	ground()
	wall(Vector3(0, 3, -10), Vector3(16, 6, 0.5))
	for x in range(-12, 13, 2):
		for z in [-14, -18, -24]:
			make.call(Vector3(x, 1, z))

# Turns and walks the first camera about.
func look_about(i: int) -> void:
	cameras[0].position = Vector3(1.7 * i - 4.0, 1.7 + 0.9 * (i % 3), 2.0 - i)
	cameras[0].rotation.y = 0.35 * sin(i * 1.3)
