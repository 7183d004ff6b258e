//! Runs the guide's plugin (guide.rs) on a manifest: prints the light map of each mesh, and what a texel of 1 shows in place of 0.18 / key.
mod guide;
use bevy::{camera::Exposure, prelude::*, scene::SceneInstanceReady};
use std::marker::PhantomData;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let manifest = std::fs::read_to_string(&arguments[1]).unwrap();
    let camera = Exposure { ev100: 7.0 };
    let map = match guide::CookedLightMap::new(&manifest, "cooked", arguments.get(2).map(|name| name.as_str()), &camera, &AssetServer) {
        Ok(map) => map,
        Err(message) => return println!("refused: {message}"),
    };
    let mut materials = Assets(vec![("shared".to_string(), StandardMaterial::default())]);
    let (mut left, mut right) = (MeshMaterial3d(Handle::at("shared")), MeshMaterial3d(Handle::at("shared")));
    let commands = Commands::default();
    // Entity 7 is a scene without a light map.
    for entity in [7, 0] {
        guide::light_scene(
            On(SceneInstanceReady { entity: Entity(entity) }),
            Query(vec![(Entity(0), &map)], PhantomData),
            Query(vec![], PhantomData),
            Query(vec![(Entity(1), &mut left), (Entity(2), &mut right)], PhantomData),
            ResMut(&mut materials),
            commands.clone(),
        );
    }
    for (entity, light_map) in commands.0.borrow().iter() {
        let mesh = if entity.0 == 1 { &left } else { &right };
        let shown = materials.get(&mesh.0).unwrap().lightmap_exposure * camera.exposure();
        println!("mesh {}: {} {} {}", entity.0, light_map.image.0, light_map.bicubic_sampling, shown);
    }
    println!("shared: {}", materials.get(&Handle::at("shared")).unwrap().lightmap_exposure);
    guide::setup(Commands::default(), Res(&AssetServer));
}
