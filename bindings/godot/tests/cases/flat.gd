extends Case
# Sprites and labels: some turn to the camera, some are drawn through walls.

var labels: Array = []

func build() -> void:
	var image := Image.create(16, 16, false, Image.FORMAT_RGBA8)
	image.fill(Color.TOMATO)
	var texture := ImageTexture.create_from_image(image)
	things_behind_a_wall(func(at: Vector3):
		var sprite := Sprite3D.new()
		sprite.texture = texture
		sprite.pixel_size = 0.1
		sprite.position = at
		sprite.billboard = labels.size() % 3 as BaseMaterial3D.BillboardMode
		add_child(sprite)
		var label := Label3D.new()
		label.text = "label"
		label.font_size = 64
		label.position = at + Vector3(0.5, 1.5, 0)
		label.billboard = labels.size() % 2 as BaseMaterial3D.BillboardMode
		label.no_depth_test = labels.size() % 11 == 4
		add_child(label)
		labels.append(label))
	sun()
	camera(Vector3(0, 1.7, 0))

func steps() -> int:
	return 8

func step(i: int) -> void:
	look_about(i)
	labels[i].text = "a much longer label"
	labels[i].position.y += 5
	if i == 4:
		labels[20].fixed_size = true
