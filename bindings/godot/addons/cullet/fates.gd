@tool
extends Object
# What may become of a node, in the order of the engine's stages: the words of CulletPreview, what the dock calls them, and
# colours that are told apart also by people who do not see all of them.

const ALL: Array[String] = ["layer", "frustum", "pvs", "occlusion", "probe", "always", "drawn"]
const NAMES := {
	"layer": "not visible, or in other layers",
	"frustum": "outside of the picture",
	"pvs": "left out by baked sets",
	"occlusion": "hidden behind others",
	"probe": "drawn for a reflection probe",
	"always": "drawn always",
	"drawn": "drawn",
}
const COLOURS := {
	"layer": Color("cc79a7"),
	"frustum": Color("8a8f98"),
	"pvs": Color("e69f00"),
	"occlusion": Color("d55e00"),
	"probe": Color("56b4e9"),
	"always": Color("f0e442"),
	"drawn": Color("00b37d"),
}
