//! The items of bevy 0.17 that the guide's plugin uses, with the types of its documentation (docs.rs/bevy/0.17): a world is a few lists here.
use std::{cell::RefCell, marker::PhantomData, ops::Deref, rc::Rc};

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Entity(pub usize);
pub trait Component {}
pub trait Event {}

pub struct Handle<T>(pub String, PhantomData<T>);
impl<T> Handle<T> {
    pub fn at(path: &str) -> Self {
        Self(path.to_string(), PhantomData)
    }
}
impl<T> Clone for Handle<T> {
    fn clone(&self) -> Self {
        Self::at(&self.0)
    }
}
impl<T> Default for Handle<T> {
    fn default() -> Self {
        Self::at("")
    }
}

pub struct Image;
pub struct Scene;
#[derive(Clone)]
pub struct StandardMaterial {
    pub lightmap_exposure: f32,
}
impl Default for StandardMaterial {
    fn default() -> Self {
        Self { lightmap_exposure: 1.0 }
    }
}
pub struct MeshMaterial3d<M>(pub Handle<M>);
pub struct SceneRoot(pub Handle<Scene>);
#[derive(Default)]
pub struct Camera3d;
pub struct Transform;
impl Transform {
    pub const fn from_xyz(_: f32, _: f32, _: f32) -> Self {
        Self
    }
}
pub struct Children;

#[derive(Clone)]
pub struct Lightmap {
    pub image: Handle<Image>,
    pub uv_rect: (f32, f32, f32, f32),
    pub bicubic_sampling: bool,
}
impl Default for Lightmap {
    fn default() -> Self {
        Self { image: Handle::default(), uv_rect: (0.0, 0.0, 1.0, 1.0), bicubic_sampling: false }
    }
}

pub struct Exposure {
    pub ev100: f32,
}
impl Default for Exposure {
    fn default() -> Self {
        Self { ev100: 9.7 }
    }
}
impl Exposure {
    pub fn exposure(&self) -> f32 {
        (-self.ev100).exp2() / 1.2
    }
}

pub struct AssetServer;
impl AssetServer {
    pub fn load<A>(&self, path: impl Into<String>) -> Handle<A> {
        Handle::at(&path.into())
    }
}

#[derive(Default)]
pub struct Assets<A>(pub Vec<(String, A)>);
impl<A> Assets<A> {
    pub fn get(&self, id: &Handle<A>) -> Option<&A> {
        self.0.iter().find(|(path, _)| *path == id.0).map(|(_, asset)| asset)
    }
    pub fn add(&mut self, asset: A) -> Handle<A> {
        let handle = Handle::at(&format!("added {}", self.0.len()));
        self.0.push((handle.0.clone(), asset));
        handle
    }
}

pub struct Res<'w, T>(pub &'w T);
impl<T> Deref for Res<'_, T> {
    type Target = T;
    fn deref(&self) -> &T {
        self.0
    }
}
pub struct ResMut<'w, T>(pub &'w mut T);
impl<T> Deref for ResMut<'_, T> {
    type Target = T;
    fn deref(&self) -> &T {
        self.0
    }
}
impl<T> std::ops::DerefMut for ResMut<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.0
    }
}

pub struct Mut<'a, T>(&'a mut T);
impl<T> Deref for Mut<'_, T> {
    type Target = T;
    fn deref(&self) -> &T {
        self.0
    }
}
impl<T> std::ops::DerefMut for Mut<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.0
    }
}

pub struct SceneInstanceReady {
    pub entity: Entity,
}
pub struct On<E>(pub E);
impl<E> Deref for On<E> {
    type Target = E;
    fn deref(&self) -> &E {
        &self.0
    }
}

/// Of `&T` or `&mut T`: the entities that have one.
pub struct Query<'w, D>(pub Vec<(Entity, D)>, pub PhantomData<&'w ()>);
impl<T> Query<'_, &T> {
    pub fn get(&self, entity: Entity) -> Result<&T, ()> {
        self.0.iter().find(|(each, _)| *each == entity).map(|(_, data)| *data).ok_or(())
    }
}
impl<T> Query<'_, &mut T> {
    pub fn get_mut(&mut self, entity: Entity) -> Result<Mut<'_, T>, ()> {
        self.0.iter_mut().find(|(each, _)| *each == entity).map(|(_, data)| Mut(&mut **data)).ok_or(())
    }
}
impl Query<'_, &Children> {
    /// Entities 1 and 2 are below entity 0.
    pub fn iter_descendants(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        (if entity.0 == 0 { vec![Entity(1), Entity(2)] } else { vec![] }).into_iter()
    }
}

/// Records the light maps that are inserted.
#[derive(Clone, Default)]
pub struct Commands(pub Rc<RefCell<Vec<(Entity, Lightmap)>>>);
pub struct EntityCommands(Entity, Commands);
impl Commands {
    pub fn entity(&mut self, entity: Entity) -> EntityCommands {
        EntityCommands(entity, self.clone())
    }
    pub fn spawn<B>(&mut self, _: B) {}
}
impl EntityCommands {
    pub fn insert(&mut self, light_map: Lightmap) -> &mut Self {
        self.1 .0.borrow_mut().push((self.0, light_map));
        self
    }
}

pub fn default<T: Default>() -> T {
    T::default()
}

pub mod camera {
    pub use crate::Exposure;
}
pub mod pbr {
    pub use crate::Lightmap;
}
pub mod scene {
    pub use crate::SceneInstanceReady;
}
pub mod prelude {
    pub use crate::{
        default, AssetServer, Assets, Camera3d, Children, Commands, Component, Entity, Handle, Image, MeshMaterial3d, On, Query, Res,
        ResMut, Scene, SceneRoot, StandardMaterial, Transform,
    };
    pub use derive::Component;
}
