@tool
extends Control
# The scene from above: a rectangle a node, and what the camera shows.

const Fates := preload("fates.gd")

var rects := {}
var lines := PackedVector2Array()
var whole := Rect2()

func _init() -> void:
	custom_minimum_size = Vector2(0, 220)
	tooltip_text = "The scene from above: nodes in the colours of the list, and the camera's picture in white. North is -Z."
	clip_contents = true

# Shows a decision; null for none.
func show_decision(decision: RefCounted, fates: Array) -> void:
	rects.clear()
	lines.clear()
	whole = Rect2()
	if decision:
		for fate: String in Fates.ALL:
			var boxes: PackedVector3Array = decision.boxes(fate)
			var of_fate: Array[Rect2] = []
			for i in range(0, boxes.size(), 2):
				var rect := Rect2(boxes[i].x, boxes[i].z, boxes[i + 1].x - boxes[i].x, boxes[i + 1].z - boxes[i].z)
				whole = rect if whole.size == Vector2.ZERO else whole.merge(rect)
				of_fate.append(rect)
			if fates.has(fate):
				rects[fate] = of_fate
		for point: Vector3 in decision.frustum(whole.size.length()):
			lines.append(Vector2(point.x, point.z))
	queue_redraw()

func _draw() -> void:
	draw_rect(Rect2(Vector2.ZERO, size), Color(0, 0, 0, 0.25))
	if whole.size.x <= 0 or whole.size.y <= 0:
		return
	var scale_by := minf(size.x / whole.size.x, size.y / whole.size.y) * 0.96
	draw_set_transform(size * 0.5 - whole.get_center() * scale_by, 0, Vector2.ONE * scale_by)
	for fate: String in rects:
		var colour: Color = Fates.COLOURS[fate]
		for rect: Rect2 in rects[fate]:
			# The ground would cover all.
			if rect.get_area() > 0.2 * whole.get_area():
				draw_rect(rect, colour, false)
			else:
				# At least a pixel wide.
				draw_rect(rect.grow(0.5 / scale_by), colour)
	if lines.size() > 1:
		draw_multiline(lines, Color.WHITE)
