# Draws room.glb, white, under the light map that the script of the guide reads from res://cooked. camera.json says from where.
extends Node3D


func _ready() -> void:
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	document.append_from_buffer(FileAccess.get_file_as_bytes("res://room.glb"), "", state)
	var room := document.generate_scene(state)
	room.name = "Room"
	add_child(room)
	for instance: MeshInstance3D in room.find_children("*", "MeshInstance3D", true, false):
		for surface in instance.mesh.get_surface_count():
			var white: StandardMaterial3D = instance.mesh.surface_get_material(surface).duplicate()
			white.albedo_color = Color.WHITE
			white.emission_enabled = false
			white.metallic = 0
			white.metallic_specular = 0
			white.roughness = 1
			instance.set_surface_override_material(surface, white)
	var view: Dictionary = JSON.parse_string(FileAccess.get_file_as_string("res://camera.json"))
	var camera := Camera3D.new()
	camera.fov = view.fov
	camera.look_at_from_position(Vector3(view.eye[0], view.eye[1], view.eye[2]), Vector3(view.target[0], view.target[1], view.target[2]))
	add_child(camera)
	var world := WorldEnvironment.new()
	world.environment = Environment.new()
	world.environment.background_mode = Environment.BG_COLOR
	world.environment.background_color = Color.BLACK
	add_child(world)
	var light_map := LightmapGI.new()
	light_map.set_script(load("res://lightcook_light_map.gd"))
	light_map.surface = ^"../Room"
	light_map.light_map = view.light_map
	add_child(light_map)
	if view.is_exposed:
		world.environment.tonemap_exposure = light_map.exposure
	for frame in 5:
		await get_tree().process_frame
	JavaScriptBridge.eval("window.shown = true")
