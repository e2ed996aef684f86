extends Case
# A world of its own within the scene, with a culler of its own; and a second culler in the first.

var views: Array = []
var inner: Camera3D

func build() -> void:
	City.build(self, 5, 4)
	sun(true)
	camera(Vector3(-4, 1.7, 60))
	var sub := SubViewport.new()
	sub.own_world_3d = true
	sub.size = Vector2i(160, 120)
	sub.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	add_child(sub)
	City.build(sub, 4, 4, 11)
	var light := DirectionalLight3D.new()
	light.rotation_degrees = Vector3(-40, 130, 0)
	sub.add_child(light)
	inner = Camera3D.new()
	sub.add_child(inner)
	inner.make_current()
	sub.add_child(CulletWorld.new())
	add_child(CulletWorld.new())
	views = [get_viewport(), sub]

func viewports() -> Array:
	return views

func step(i: int) -> void:
	City.walk(cameras[0], 0.35 + 0.02 * i)
	inner.position = Vector3(-4, 1.7, 40 - 6 * i)
	inner.rotation.y = 0.5 * sin(i)
