extends Case
# Three cameras of one world that look apart, a sun and a lamp with shadows.

var views: Array = []

func build() -> void:
	City.build(self, 8, 8)
	sun(true)
	var lamp := OmniLight3D.new()
	lamp.position = Vector3(-4, 5, 30)
	lamp.omni_range = 40
	lamp.light_energy = 4
	lamp.shadow_enabled = true
	add_child(lamp)
	camera(Vector3.ZERO)
	for i in 2:
		var sub := SubViewport.new()
		sub.size = Vector2i(200, 120)
		sub.world_3d = get_viewport().find_world_3d()
		sub.render_target_update_mode = SubViewport.UPDATE_ALWAYS
		add_child(sub)
		views.append(sub)
		camera(Vector3.ZERO, 0.0, sub)
	views.push_front(get_viewport())

func viewports() -> Array:
	return views

func step(i: int) -> void:
	for k in 3:
		cameras[k].position = Vector3(-4, 1.7, 60.0 - i * 17.0 + k * 10)
		cameras[k].rotation.y = i * 0.5 + k * 2.1

func most_drawn() -> float:
	return 0.4
