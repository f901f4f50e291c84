//! The lowered forms: what a backend can run. All are plain data.
//!
//! A [`Scene`] holds one cyclic CSG [`Graph`] (GT95, section 2.2) and what is needed to look at it. The forms know nothing of
//! the text they come from but [`Origin`]s, so a scene can also be built in Rust by hand.

mod code;
mod graph;
mod graph_check;
mod origin;
mod primitive;
mod raster;
mod scene;
mod segments;
mod texture;
mod unclipped;
mod value;
mod walk;
mod walk_check;

pub use code::{BinaryOp, Builtin, Code, Draw, Function, FunctionId, Op, Reg, Slot, UnaryOp};
pub use graph::{
    Call, Choice, Formal, Graph, GraphError, Node, NodeId, Rule, Select, SelectId, System, SystemCall, SystemId,
    TransformKind,
};
pub use origin::Origin;
pub use primitive::{MeshId, PrimitiveKind};
pub use raster::{Raster, Texel};
pub use scene::{Background, Camera, ImageSettings, Lens, Material, MaterialId, Scene, Sky, Sun};
pub use segments::{Segment, SegmentList, Stem, StemEnd, StemStart};
pub use texture::{Chunks, Fbm, Fourier, Image, Pattern, Space, Texture, TextureId};
pub use value::{Value, Vector};
pub use walk::{Bracket, Module, ModuleId, Order, Shape, ShapeId, Splitting, Stride, Walk, WalkRule};
