//! A tracer for tests: spheres over a ground plane, by closed forms.

use glam::DVec3;
use treegen_runtime::form::{
    Camera, Code, Graph, ImageSettings, Lens, Material, MaterialId, Node, NodeId, Origin, Scene, Sun, System, SystemId,
};
use treegen_runtime::geometry::{Aabb, Ray};
use treegen_runtime::trace::{Beam, Fragment, RayFault, Seen, Site, SurfaceBeam, Tracer};
use treegen_runtime::{Fault, FaultKind};

/// A sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sphere {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
    pub(crate) material: Option<MaterialId>,
}

/// The spheres, and the plane z = 0 where it is wanted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spheres {
    pub(crate) spheres: Vec<Sphere>,
    pub(crate) ground: bool,
    /// Rays that come down in here, on the plane z = 0, meet a fault.
    pub(crate) faulty: Option<fn(DVec3) -> bool>,
    /// The same for rays that start on something.
    pub(crate) faulty_image: Option<fn(DVec3) -> bool>,
}

/// A sphere without paint.
pub(crate) fn sphere(center: [f64; 3], radius: f64) -> Sphere {
    Sphere { center: center.into(), radius, material: None }
}

/// A scene around an empty graph: the tracer brings what is seen.
pub(crate) fn scene(camera: Camera, suns: Vec<Sun>, size: (u32, u32), samples: u32) -> Scene {
    let system = System {
        name: "Nothing".into(),
        slots: Vec::new(),
        formals: Vec::new(),
        lets: Code::default(),
        vars: Code::default(),
        start: NodeId(0),
        origin: Origin::NONE,
    };
    Scene {
        graph: Graph::new(vec![Node::Empty], Vec::new(), vec![system], Vec::new(), SystemId(0)).unwrap(),
        seed: 0,
        materials: vec![Material { color: [1.0; 3], name: "White".into(), ..Material::default() }],
        textures: Vec::new(),
        camera: Some(camera),
        suns,
        sky: None,
        image: ImageSettings { width: size.0, height: size.1, samples, ..ImageSettings::default() },
    }
}

/// A camera that looks straight down in parallel, with y up in the picture.
pub(crate) fn from_above(span: f64) -> Camera {
    Camera { eye: DVec3::Z * 100.0, target: DVec3::ZERO, up: DVec3::Y, lens: Lens::Orthographic(span) }
}

/// A white sun whose light travels this way.
pub(crate) fn sun(direction: [f64; 3]) -> Sun {
    Sun { direction: direction.into(), color: [1.0; 3], strength: 1.0, size: 0.0 }
}

impl Spheres {
    /// The nearest thing ahead, but for the one the ray starts on: all are convex.
    fn nearest(&self, ray: &Ray, from: Option<u32>) -> Option<(f64, u32)> {
        let ground =
            (self.ground && from != Some(0) && ray.direction.z != 0.0).then(|| (-ray.origin.z / ray.direction.z, 0));
        let spheres = self.spheres.iter().zip(1..).filter(|(_, number)| from != Some(*number));
        spheres
            .filter_map(|(sphere, number)| Some((sphere.enter(ray)?, number)))
            .chain(ground)
            .filter(|(t, _)| *t > 0.0)
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn fragment(&self, ray: &Ray, (t, number): (f64, u32)) -> Fragment {
        let position = ray.at(t);
        let sphere = number.checked_sub(1).map(|index| self.spheres[index as usize]);
        let normal = sphere.map_or(DVec3::Z, |sphere| (position - sphere.center) / sphere.radius);
        Fragment {
            material: sphere.map_or(Some(MaterialId(0)), |sphere| sphere.material),
            route: u64::from(number),
            site: Site { path: [number].into_iter().collect(), face: 0 },
            ..Fragment::of_surface(t, position, normal, Origin::NONE)
        }
    }

    fn fault(ray: &Ray, faulty: Option<fn(DVec3) -> bool>) -> Option<Fault> {
        let ground = ray.at(-ray.origin.z / ray.direction.z);
        faulty.is_some_and(|faulty| faulty(ground)).then(|| {
            let (x, y) = (ground.x.floor(), ground.y.floor());
            let kind = FaultKind::Range { name: "place".into(), value: x, low: y, high: 0.0, range: Origin::NONE };
            Fault::new(kind, Origin::NONE)
        })
    }
}

impl Sphere {
    fn enter(&self, ray: &Ray) -> Option<f64> {
        let middle = (self.center - ray.origin).dot(ray.direction);
        let nearest = ray.at(middle) - self.center;
        let half_square = self.radius * self.radius - nearest.length_squared();
        (half_square > 0.0).then(|| middle - half_square.sqrt())
    }
}

impl Tracer for Spheres {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        seen.clear();
        for (number, Beam { ray, .. }) in beams.iter().enumerate() {
            if let Some(fault) = Self::fault(ray, self.faulty) {
                return Err(RayFault { ray: number, fault });
            }
            self.nearest(ray, None).into_iter().for_each(|hit| seen.push(self.fragment(ray, hit)));
            seen.end_ray();
        }
        Ok(())
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        seen.clear();
        for (number, SurfaceBeam { beam: Beam { ray, .. }, from }) in beams.iter().enumerate() {
            if let Some(fault) = Self::fault(ray, self.faulty_image) {
                return Err(RayFault { ray: number, fault });
            }
            let nearest = self.nearest(ray, from.path.part(0));
            nearest.into_iter().for_each(|hit| seen.push(self.fragment(ray, hit)));
            seen.end_ray();
        }
        Ok(())
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        work.clear();
        work.extend(beams.iter().map(|it| u32::from(self.nearest(&it.ray, None).is_some())));
        Ok(())
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        light.clear();
        let blocked = |it: &SurfaceBeam| self.nearest(&it.beam.ray, it.from.path.part(0)).is_some();
        light.extend(beams.iter().map(|it| if blocked(it) { 0.0 } else { 1.0 }));
        Ok(())
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        let boxes = self.spheres.iter().map(|s| Aabb { min: s.center - s.radius, max: s.center + s.radius });
        Ok(boxes.fold(Aabb::EMPTY, |all, one| all.union(&one)))
    }
}
