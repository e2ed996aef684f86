extends Case
# Temporal antialiasing, where the renderer has it: each picture is moved by part of a pixel and mixed with those before.

func build() -> void:
	City.build(self, 6, 8)
	sun()
	camera(Vector3(-4, 1.7, 60))
	get_viewport().use_taa = true

func steps() -> int:
	return 32

func step(i: int) -> void:
	City.walk(cameras[0], 0.35 + 0.004 * i)

func most_drawn() -> float:
	return 0.3

func _exit_tree() -> void:
	get_viewport().use_taa = false
