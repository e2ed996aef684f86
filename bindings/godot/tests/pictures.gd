class_name Pictures
# Pictures of viewports, and how many of their pixels differ.

static func of(viewport: Viewport) -> PackedInt32Array:
	var image := viewport.get_texture().get_image()
	image.convert(Image.FORMAT_RGBA8)
	return image.get_data().to_int32_array()

static func differing(a: PackedInt32Array, b: PackedInt32Array) -> int:
	if a == b:
		return 0
	var count := absi(a.size() - b.size())
	for i in mini(a.size(), b.size()):
		count += int(a[i] != b[i])
	return count

# Pipelines are made in the background, and what has none yet is not drawn. Waits until ten pictures in turn are the same; call it
# while nothing moves and nothing is culled.
static func settle(viewports: Array) -> void:
	var last := []
	var same := 0
	for i in 400:
		await RenderingServer.frame_post_draw
		var now := viewports.map(of)
		same = same + 1 if now == last else 0
		last = now
		if same >= 10:
			return
	push_error("the picture never came to rest")
