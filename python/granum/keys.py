"""The keys of a case: what `granum.Case` takes, each with its meaning, bounds and unit.

Made by python/tools/generate_keys.py from the declarations by which case files are read; do not edit it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, TypedDict

Quantity: TypeAlias = Any
"""A number in SI units, a text with a unit such as `"0.2 mm"`, a number of NumPy, or a quantity of pint."""

Quantities: TypeAlias = Any
"""A sequence of quantities, or of such sequences; an array, a frame of pandas or a quantity of pint with an array."""


class Bond(TypedDict, total=False):
    """A set of bonds that is made before a stage."""

    attachment: Literal["contact", "middle"]
    """Where a bond is attached to its two pieces: where they touch, unless it is given. For pieces of one size both
    are the same. contact: where the pieces touch, at the distances of their radii from their centres; middle:
    halfway between their centres, as LAMMPS attaches bonds
    """
    before_stage: int
    """Number of the stage before which bonds are made; before the first the sample carries the stress of its
    preparation. Default: 1.0.
    """
    cement_content: Quantity
    """Mass of the cement over that of the grains, from which the radius follows; in place of radius."""
    cement_density: Quantity
    """Density of the cement; only together with cement_content. Default: 3100.0."""
    cohesion: Quantity
    """Largest shear stress c, twist included, that the bond carries without normal stress; without a value it never
    ruptures in shear.
    """
    damping: Quantity
    """Damping ratio of the four motions of a bond. Default: 0.0."""
    friction_angle: Quantity
    """Angle phi_b by which compression raises the strength in shear: tau_c = c + sigma tan(phi_b)."""
    largest_gap: Quantity
    """Largest distance of two surfaces that are joined, over the mean diameter; 0: those that touch. Default: 0.0."""
    law: Literal["parallel", "beam", "additive"]
    """How stiff and how strong bonds are. parallel: springs over the section of a cylinder; ruptures by tension with
    bending, or by shear after Mohr and Coulomb; beam: a cylinder that bends and shears as Timoshenko's beam;
    ruptures as parallel bonds; additive: stiff as parallel bonds; ruptures where the sum of the four loads over
    their limits reaches one Default: parallel.
    """
    left_out: Quantity
    """Share of the bonds, drawn at random, that are left out. Default: 0.0."""
    modulus: Quantity
    """Young's modulus E_b of the bond."""
    moment_factor: Quantity
    """Share beta of the couples in the stresses that rupture the bond."""
    places: Literal["between", "inside", "file"]
    """Which pieces are joined. between: pieces of different grains that touch, or are nearer than largest_gap;
    inside: the touching pieces of each grain, which becomes an agglomerate of spheres that can come apart; file:
    the pairs that the packing of the run lists, as the section Bonds of a LAMMPS data file does Default: between.
    """
    poissons_ratio: Quantity
    """Poisson's ratio of the bond, from which its shear modulus E_b / 2 (1 + nu) follows."""
    radius: Quantity
    """Radius of a bond over that of the smaller of its two pieces. Default: 0.5."""
    reference_volume: Quantity
    """Volume of a bond that has the given strength; others have it times (V/V0)^(-1/m). Only with scatter =
    "weibull".
    """
    scatter: Literal["none", "normal", "weibull"]
    """How the strengths of bonds scatter. none: all bonds are equally strong; normal: normally distributed, with
    strength_deviation; weibull: after Weibull, with weibull_modulus Default: none.
    """
    seed: int
    """Seed of the scatter and of what is left out. Default: 1.0."""
    shear_coefficient: Quantity
    """Shear coefficient kappa of the section: 6 (1 + nu) / (7 + 6 nu) for a full circle."""
    stiffness_ratio: Quantity
    """Ratio of the normal to the shear stiffness, k_n / k_s; 0: it follows from Poisson's ratio."""
    strength_deviation: Quantity
    """Standard deviation of the strength over its mean; only with scatter = "normal". Default: 0.2."""
    tensile_strength: Quantity
    """Largest tension sigma_c, bending included, that the bond carries; without a value it never ruptures in
    tension.
    """
    type: int
    """Only the pairs of this type of the packing; without it those of all types. Only with places = "file"."""
    weibull_modulus: Quantity
    """Modulus m of Weibull's distribution; only with scatter = "weibull". Default: 4.0."""


class Contact(TypedDict, total=False):
    """The contact law."""

    adhesion: Literal["none", "capillary-bridge", "capillary-bridge-films", "van-der-waals"]
    """Additional attraction of grains, which may act across a gap. none: no force in addition to the contact law;
    capillary-bridge: liquid bridges of constant volume that form when grains touch: Willett et al. 2000;
    capillary-bridge-films: liquid bridges that take their liquid from films on the grains and return it when they
    rupture; van-der-waals: van der Waals attraction beyond touch, with a least separation and a cut-off: Hamaker
    1937 Default: none.
    """
    attraction_cutoff: Quantity
    """Gap D_c of the surfaces at which the attraction ends; it is continuous there; with adhesion = "van-der-waals".
    (from 1e-10 m to 1e-5 m, or a number in m) Default: 5e-8 m.
    """
    bridge_volume: Quantity
    """Volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j); with adhesion = "capillary-bridge". (from
    1e-6 to 0.1) Default: 0.01.
    """
    cohesion_ratio: Quantity
    """Stiffness k_c of the branch of cohesion over that of first loading; 0 for no cohesion; with normal = "luding".
    (from 0 to 1000) Default: 0.2.
    """
    contact_angle: Quantity
    """Contact angle theta of the liquid on the grains; with adhesion = "capillary-bridge" or adhesion =
    "capillary-bridge-films". (from 0 rad to 1.5 rad, or a number in rad) Default: 0 rad.
    """
    damping: Quantity
    """Fraction zeta of critical damping in the contact dashpots. (from 0 to 1) Default: 0.1."""
    equilibrium_separation: Quantity
    """Separation z_0 of the surfaces at equilibrium, about the range of the attraction: with the size of the grains
    it determines whether their adhesion is close to JKR or to DMT; with normal = "jkr-dmt". (from 1e-11 m to 1e-6
    m, or a number in m) Default: 4e-10 m.
    """
    hamaker_constant: Quantity
    """Hamaker's constant A of the material of the grains in their medium; with adhesion = "van-der-waals". (from 0 J
    to 1e-17 J, or a number in J) Default: 6.5e-20 J.
    """
    largest_bridge_volume: Quantity
    """Largest volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j), where the films have that much
    liquid; with adhesion = "capillary-bridge-films". (from 1e-6 to 0.1) Default: 0.02.
    """
    least_separation: Quantity
    """Gap D_0 of the surfaces below which their attraction is constant, also for touching grains; with adhesion =
    "van-der-waals". (from 1e-11 m to 1e-6 m, or a number in m) Default: 4e-10 m.
    """
    liquid_content: Quantity
    """Volume of the liquid on a grain at the start over the volume of the grain; with adhesion =
    "capillary-bridge-films". (from 0 to 0.3) Default: 0.01.
    """
    normal: Literal["hertz", "jkr", "hooke", "dmt", "jkr-dmt", "rough-hertz", "luding"]
    """Normal law. hertz: elastic spheres without adhesion; jkr: adhesive: Johnson, Kendall and Roberts 1971; hooke:
    a linear spring of stiffness contact.normal_stiffness, without adhesion; dmt: adhesive, for small or stiff
    grains: Derjaguin, Muller and Toporov 1975; jkr-dmt: adhesive, between JKR and DMT by the size of the grains:
    Schwarz 2003, Carpick et al. 1999; rough-hertz: elastic spheres with rough surfaces, softer than Hertz under
    small loads: Otsubo et al. 2017; luding: elastic-plastic and adhesive, linear, with memory of the largest
    overlap: Luding 2008 Default: jkr.
    """
    normal_stiffness: Quantity
    """Stiffness k_n of the linear spring of every contact; at first loading where contacts are plastic; with normal
    = "hooke" or normal = "luding". (from 1 N/m to 1e10 N/m, or a number in N/m) Default: 10000 N/m.
    """
    plasticity_depth: Quantity
    """Plastic overlap phi_f beyond which contacts are elastic, over 2 R_i R_j / (R_i + R_j); with normal = "luding".
    (from 1e-6 to 0.5) Default: 0.05.
    """
    rolling: Literal["none", "elastic-plastic", "elastic-plastic-twisting", "spring-dashpot-slider"]
    """Resistance to rolling and twisting. none: contacts resist neither rolling nor twisting; elastic-plastic: a
    spring, a slider and a dashpot against rolling: model C of Ai et al. 2011; elastic-plastic-twisting:
    elastic-plastic against rolling, and likewise against twisting, with a coefficient of its own;
    spring-dashpot-slider: a spring of constant stiffness and a dashpot with a slider against rolling: Luding
    2008, as rolling sds in LAMMPS Default: none.
    """
    rolling_damping: Quantity
    """Fraction zeta_r of critical damping of the rolling spring below its limit; with rolling = "elastic-plastic" or
    rolling = "elastic-plastic-twisting". (from 0 to 1) Default: 0.3.
    """
    rolling_friction: Quantity
    """Coefficient mu_r of rolling friction: the rolling couple is at most mu_r R* N; with rolling =
    "elastic-plastic" or rolling = "elastic-plastic-twisting" or rolling = "spring-dashpot-slider". (from 0 to 2)
    Default: 0.1.
    """
    rolling_stiffness: Quantity
    """Stiffness k_r of the rolling spring of every contact, relative to the displacement R* times the angle of
    rolling; with rolling = "spring-dashpot-slider". (from 0.001 N/m to 1e10 N/m, or a number in N/m) Default:
    1000 N/m.
    """
    rolling_viscosity: Quantity
    """Coefficient gamma_r of the rolling dashpot of every contact, relative to R* times the rate of rolling; with
    rolling = "spring-dashpot-slider". (from 0 N s/m to 1000000 N s/m, or a number in N s/m) Default: 0.001 N s/m.
    """
    roughness: Quantity
    """Root mean square roughness S_q of the surface of a grain; that of a contact is (S_i^2 + S_j^2)^(1/2); with
    normal = "rough-hertz". (from 0 m to 1e-4 m, or a number in m) Default: 1e-7 m.
    """
    rupture_coefficient: Quantity
    """Coefficient c of the rupture distance R_e (1 + theta/2) (v^(1/3) + c v^(2/3)), v = V/R_e^3: 0.1 of Willett et
    al. 2000, 0 of Lian et al. 1993; with adhesion = "capillary-bridge" or adhesion = "capillary-bridge-films".
    (from 0 to 1) Default: 0.1.
    """
    surface_tension: Quantity
    """Surface tension gamma of the liquid of the bridges; with adhesion = "capillary-bridge" or adhesion =
    "capillary-bridge-films". (from 0 N/m to 10 N/m, or a number in N/m) Default: 0.072 N/m.
    """
    tangential: Literal["mindlin-deresiewicz", "no-slip", "peeling"]
    """Tangential law. mindlin-deresiewicz: incremental, with turning points: Mindlin and Deresiewicz 1953, Thornton
    and Yin 1991; no-slip: no-slip Mindlin; with normal = "hooke" a linear spring and a slider; peeling:
    Mindlin-Deresiewicz after Savkoor-Briggs peeling; needs normal = "jkr" Default: mindlin-deresiewicz.
    """
    tangential_stiffness_ratio: Quantity
    """Tangential stiffness over the normal stiffness, k_t/k_n, for a normal law without contact area; with
    tangential = "no-slip". (from 0 to 1) Default: 0.2857142857142857.
    """
    twisting_damping: Quantity
    """Fraction zeta_t of critical damping of the twisting spring below its limit; with rolling =
    "elastic-plastic-twisting". (from 0 to 1) Default: 0.3.
    """
    twisting_friction: Quantity
    """Coefficient mu_t of twisting friction: the couple about the normal is at most mu_t R* N; with rolling =
    "elastic-plastic-twisting". (from 0 to 2) Default: 0.05.
    """
    unloading_ratio: Quantity
    """Stiffness k_p of the hardest unloading over that of first loading, contact.normal_stiffness; with normal =
    "luding". (from 1.001 to 1000) Default: 5.0.
    """


class GrainsMaterial(TypedDict, total=False):
    """What the grains are made of."""

    density: Quantity
    """Density rho of the solid. (from 1 kg/m3 to 100000 kg/m3, or a number in kg/m3) Default: 2650 kg/m3."""
    friction: Quantity
    """Coefficient of friction mu between grains, in the test. (from 0 to 10) Default: 0.3."""
    interface_energy: Quantity
    """Interface energy Gamma: work of adhesion per area, used by normal = "jkr", "dmt" and "jkr-dmt"; 0 is no
    adhesion. (from 0 J/m2 to 100 J/m2, or a number in J/m2) Default: 0.6 J/m2.
    """
    poissons_ratio: Quantity
    """Poisson's ratio nu. (from 0 to 0.5) Default: 0.3."""
    youngs_modulus: Quantity
    """Young's modulus E. (from 1 kPa to 10 TPa, or a number in Pa) Default: 70 GPa."""


class GrainsShape(TypedDict, total=False):
    """The shape of the grains: rigid bodies of several spheres. Several shapes: tables [[grains.shape]] with share."""

    agglomerate_spheres: Quantity
    """Number of spheres of an agglomerate before any are taken out; with kind = "agglomerate". (from 4 to 1000)
    Default: 43.0.
    """
    angularity: Quantity
    """Roughness D_3 of a random grain: root mean square of the part of degree 3 of its radius over the radius. 0 is
    an ellipsoid; with kind = "sand". (from 0 to 0.06) Default: 0.03.
    """
    arm: Quantity
    """Distance of the centres of the spheres of a tetrapod from its centre over their diameter; with kind =
    "tetrapod". (from 0.05 to 0.612) Default: 0.43301270189221935.
    """
    aspect_ratio: Quantity
    """Length over thickness; with kind = "capsule". (from 1.01 to 6) Default: 1.5."""
    elongation: Quantity
    """Intermediate over largest length, b/a: 1 is as wide as long; with kind = "ellipsoid" or kind = "sand". (from
    0.2 to 1) Default: 0.8.
    """
    file: str
    """The file of kind = "mesh" (STL, OBJ or PLY) or "voxels" (TIFF). The case of a run has the spheres and needs no
    file.
    """
    flatness: Quantity
    """Least over intermediate length, c/b: 1 is as thick as wide; with kind = "ellipsoid" or kind = "sand". (from
    0.2 to 1) Default: 0.8.
    """
    flaws: Quantity
    """Share of the spheres of an agglomerate that are taken out at random; with kind = "agglomerate". (from 0 to
    0.4) Default: 0.0.
    """
    kind: Literal["sphere", "agglomerate", "dimer", "capsule", "ellipsoid", "sand", "mesh", "mesh-euclidean", "mesh-tangent", "tetrapod", "voxels", "pieces"]
    """Family of the shape. sphere: spheres; agglomerate: equal spheres of the densest lattice inside of a ball,
    which touch: with bonds inside they can come apart; dimer: two equal spheres; capsule: equal spheres in a row:
    a cylinder with round ends; ellipsoid: spheres that touch an ellipsoid from inside; sand: random grains, rough
    ellipsoids; mesh: a mesh in an STL, OBJ or PLY file, covered by the spheres that fill most of it;
    mesh-euclidean: a mesh in a file, covered by the largest spheres that fit, one after the other; mesh-tangent:
    a mesh in a file, covered by spheres that touch it at random points; tetrapod: four equal spheres at the
    corners of a tetrahedron; voxels: the grains of a labelled stack of images, a TIFF file or a folder of them;
    pieces: the spheres of the list `spheres` Default: sphere.
    """
    overlap: Quantity
    """Share of its radius up to which the spheres of a cover may enter a sphere; with kind = "mesh-euclidean". (from
    0 to 0.95) Default: 0.7.
    """
    pieces: Quantity
    """Number of spheres: more of them are smoother and take longer; with kind = "capsule", kind = "ellipsoid", kind
    = "sand", kind = "mesh", kind = "mesh-euclidean", kind = "mesh-tangent" or kind = "voxels". (from 2 to 200)
    Default: 3.0.
    """
    separation: Quantity
    """Distance of the centres of the two spheres over their diameter; with kind = "dimer". (from 0.01 to 1) Default:
    0.5.
    """
    shape_seed: Quantity
    """Seed of the random numbers of shapes: another seed gives other shapes of the same kind; with kind =
    "agglomerate", kind = "sand" or kind = "mesh-tangent". (from 0 to 4.294967295e9) Default: 1.0.
    """
    shapes: Quantity
    """Number of shapes that differ from each other; each grain has one of them; with kind = "agglomerate" or kind =
    "sand". (from 1 to 50) Default: 10.0.
    """
    spacing_y: Quantity
    """Distance of the rows of an image over that of its columns; with kind = "voxels". (from 0.01 to 100) Default:
    1.0.
    """
    spacing_z: Quantity
    """Distance of the images of a stack over that of the columns of an image; with kind = "voxels". (from 0.01 to
    100) Default: 1.0.
    """
    spheres: Quantities | Literal["none"]
    """The spheres of kind = "pieces": centre and radius of each, [[x, y, z, radius], ...], in any unit of length.
    Default: none.
    """
    largest: Quantity
    """Largest diameter of the grains that have this shape; if left out: any."""
    material: str
    """Name of the material whose grains have this shape; if left out: all."""
    share: Quantity
    """Share of the mass of the grains; one may be left out and gets the rest; all are equal if none is given."""
    smallest: Quantity
    """Smallest diameter of the grains that have this shape; if left out: any."""


class Grains(TypedDict, total=False):
    """The grains: how many and how large."""

    count: Quantity
    """Number of grains. (from 50 to 100000000) Default: 5000.0."""
    diameter: Quantity
    """Mean diameter d. (from 10 nm to 10 m, or a number in m) Default: 0.1 mm."""
    distribution: Literal["uniform", "equal", "normal", "lognormal", "two-sizes", "weibull", "fractal", "sieve-curve"]
    """Distribution of the diameters. uniform: radii drawn uniformly around the mean, as wide as spread says; equal
    grains with spread = 0; equal: all grains have the same diameter; normal: normal distribution by number, with
    the relative deviation size_deviation; lognormal: lognormal distribution by number, with the relative
    deviation size_deviation; two-sizes: fine and coarse grains, with size_ratio and fine_share; weibull: Weibull
    distribution by number, with the modulus size_modulus; fractal: number of larger grains by a power of the
    diameter, fractal_dimension, between smallest and largest; sieve-curve: the sieve curve of sieve_curve, by
    mass Default: uniform.
    """
    fine_share: Quantity
    """Share of the fine grains by mass; with distribution = "two-sizes". (from 0 to 1) Default: 0.3."""
    fractal_dimension: Quantity
    """Fractal dimension D: the number of grains larger than x is proportional to x^-D; with distribution =
    "fractal". (from 0.1 to 4) Default: 2.5.
    """
    largest: Quantity
    """Largest diameter: the distribution is cut there. (from 1 nm to 10 m, or a number in m) Default: none."""
    material: GrainsMaterial
    """What the grains are made of."""
    shape: GrainsShape | Sequence[GrainsShape]
    """The shape of the grains: rigid bodies of several spheres. Several shapes: tables [[grains.shape]] with share."""
    sieve_curve: Quantities | str
    """Sieve curve of distribution = "sieve-curve": the name of a CSV file with the columns diameter (mm),finer (%),
    or a list of points. Default: none.
    """
    size_deviation: Quantity
    """Standard deviation of the diameters over their mean, by number, before a cut; with distribution = "normal" or
    distribution = "lognormal". (from 0.001 to 2) Default: 0.2.
    """
    size_measure: Literal["volume", "sieve"]
    """What a diameter means where grains are not spheres. volume: the diameter of the sphere of equal volume; sieve:
    the edge of the smallest square hole that the grain passes: its intermediate length Default: volume.
    """
    size_modulus: Quantity
    """Modulus m (exponent) of the Weibull distribution of diameters; with distribution = "weibull". (from 0.5 to
    100) Default: 3.0.
    """
    size_ratio: Quantity
    """Diameter of the coarse grains over that of the fine grains; with distribution = "two-sizes". (from 1 to 50)
    Default: 2.0.
    """
    smallest: Quantity
    """Smallest diameter: the distribution is cut there. (from 1 nm to 10 m, or a number in m) Default: none."""
    spread: Quantity
    """Half-width of the uniform distribution of radii relative to the mean; 0 makes equal grains. (from 0 to 0.9)
    Default: 0.0.
    """


class Material(TypedDict, total=False):
    """A material."""

    attraction_cutoff: Quantity
    """Gap D_c of the surfaces at which the attraction ends; it is continuous there; with adhesion = "van-der-waals".
    (from 1e-10 m to 1e-5 m, or a number in m)
    """
    bridge_volume: Quantity
    """Volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j); with adhesion = "capillary-bridge". (from
    1e-6 to 0.1)
    """
    cohesion_ratio: Quantity
    """Stiffness k_c of the branch of cohesion over that of first loading; 0 for no cohesion; with normal = "luding".
    (from 0 to 1000)
    """
    contact_angle: Quantity
    """Contact angle theta of the liquid on the grains; with adhesion = "capillary-bridge" or adhesion =
    "capillary-bridge-films". (from 0 rad to 1.5 rad, or a number in rad)
    """
    density: Quantity
    """Density rho of the solid. (from 1 kg/m3 to 100000 kg/m3, or a number in kg/m3)"""
    equilibrium_separation: Quantity
    """Separation z_0 of the surfaces at equilibrium, about the range of the attraction: with the size of the grains
    it determines whether their adhesion is close to JKR or to DMT; with normal = "jkr-dmt". (from 1e-11 m to 1e-6
    m, or a number in m)
    """
    friction: Quantity
    """Coefficient of friction mu between grains, in the test. (from 0 to 10)"""
    hamaker_constant: Quantity
    """Hamaker's constant A of the material of the grains in their medium; with adhesion = "van-der-waals". (from 0 J
    to 1e-17 J, or a number in J)
    """
    interface_energy: Quantity
    """Interface energy Gamma: work of adhesion per area, used by normal = "jkr", "dmt" and "jkr-dmt"; 0 is no
    adhesion. (from 0 J/m2 to 100 J/m2, or a number in J/m2)
    """
    largest_bridge_volume: Quantity
    """Largest volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j), where the films have that much
    liquid; with adhesion = "capillary-bridge-films". (from 1e-6 to 0.1)
    """
    least_separation: Quantity
    """Gap D_0 of the surfaces below which their attraction is constant, also for touching grains; with adhesion =
    "van-der-waals". (from 1e-11 m to 1e-6 m, or a number in m)
    """
    liquid_content: Quantity
    """Volume of the liquid on a grain at the start over the volume of the grain; with adhesion =
    "capillary-bridge-films". (from 0 to 0.3)
    """
    name: str
    """Its name, of letters, digits, - and _. The order of the materials does not matter."""
    normal_stiffness: Quantity
    """Stiffness k_n of the linear spring of every contact; at first loading where contacts are plastic; with normal
    = "hooke" or normal = "luding". (from 1 N/m to 1e10 N/m, or a number in N/m)
    """
    plasticity_depth: Quantity
    """Plastic overlap phi_f beyond which contacts are elastic, over 2 R_i R_j / (R_i + R_j); with normal = "luding".
    (from 1e-6 to 0.5)
    """
    poissons_ratio: Quantity
    """Poisson's ratio nu. (from 0 to 0.5)"""
    rolling_damping: Quantity
    """Fraction zeta_r of critical damping of the rolling spring below its limit; with rolling = "elastic-plastic" or
    rolling = "elastic-plastic-twisting". (from 0 to 1)
    """
    rolling_friction: Quantity
    """Coefficient mu_r of rolling friction: the rolling couple is at most mu_r R* N; with rolling =
    "elastic-plastic" or rolling = "elastic-plastic-twisting" or rolling = "spring-dashpot-slider". (from 0 to 2)
    """
    rolling_stiffness: Quantity
    """Stiffness k_r of the rolling spring of every contact, relative to the displacement R* times the angle of
    rolling; with rolling = "spring-dashpot-slider". (from 0.001 N/m to 1e10 N/m, or a number in N/m)
    """
    rolling_viscosity: Quantity
    """Coefficient gamma_r of the rolling dashpot of every contact, relative to R* times the rate of rolling; with
    rolling = "spring-dashpot-slider". (from 0 N s/m to 1000000 N s/m, or a number in N s/m)
    """
    roughness: Quantity
    """Root mean square roughness S_q of the surface of a grain; that of a contact is (S_i^2 + S_j^2)^(1/2); with
    normal = "rough-hertz". (from 0 m to 1e-4 m, or a number in m)
    """
    rupture_coefficient: Quantity
    """Coefficient c of the rupture distance R_e (1 + theta/2) (v^(1/3) + c v^(2/3)), v = V/R_e^3: 0.1 of Willett et
    al. 2000, 0 of Lian et al. 1993; with adhesion = "capillary-bridge" or adhesion = "capillary-bridge-films".
    (from 0 to 1)
    """
    share: Quantity
    """Share of the grains, by number; one may be left out and gets the rest; all are equal if none is given. Which
    grain has which material is drawn at random from preparation.seed.
    """
    surface_tension: Quantity
    """Surface tension gamma of the liquid of the bridges; with adhesion = "capillary-bridge" or adhesion =
    "capillary-bridge-films". (from 0 N/m to 10 N/m, or a number in N/m)
    """
    tangential_stiffness_ratio: Quantity
    """Tangential stiffness over the normal stiffness, k_t/k_n, for a normal law without contact area; with
    tangential = "no-slip". (from 0 to 1)
    """
    twisting_damping: Quantity
    """Fraction zeta_t of critical damping of the twisting spring below its limit; with rolling =
    "elastic-plastic-twisting". (from 0 to 1)
    """
    twisting_friction: Quantity
    """Coefficient mu_t of twisting friction: the couple about the normal is at most mu_t R* N; with rolling =
    "elastic-plastic-twisting". (from 0 to 2)
    """
    unloading_ratio: Quantity
    """Stiffness k_p of the hardest unloading over that of first loading, contact.normal_stiffness; with normal =
    "luding". (from 1.001 to 1000)
    """
    youngs_modulus: Quantity
    """Young's modulus E. (from 1 kPa to 10 TPa, or a number in Pa)"""


class Numerics(TypedDict, total=False):
    """Numerical choices that should not change a result beyond scatter."""

    largest_overlap: Quantity
    """Largest overlap of two grains over the sum of their radii: a run ends beyond it. More than a tenth only for
    very soft or plastic grains. (from 0.1 to 0.5) Default: usual.
    """
    time_step_factor: Quantity
    """Time step as a fraction of sqrt(m / k_t) of the stiffest contact; shortened where contact.damping is above
    0.1. (from 0.0001 to 1) Default: 0.2.
    """


class Pair(TypedDict, total=False):
    """Values for a pair of materials."""

    attraction_cutoff: Quantity
    """Gap D_c of the surfaces at which the attraction ends; it is continuous there; with adhesion = "van-der-waals".
    (from 1e-10 m to 1e-5 m, or a number in m)
    """
    between: Sequence[str]
    """The names of two materials, or one name twice: the values apply to contacts between their grains."""
    bridge_volume: Quantity
    """Volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j); with adhesion = "capillary-bridge". (from
    1e-6 to 0.1)
    """
    cohesion_ratio: Quantity
    """Stiffness k_c of the branch of cohesion over that of first loading; 0 for no cohesion; with normal = "luding".
    (from 0 to 1000)
    """
    contact_angle: Quantity
    """Contact angle theta of the liquid on the grains; with adhesion = "capillary-bridge" or adhesion =
    "capillary-bridge-films". (from 0 rad to 1.5 rad, or a number in rad)
    """
    equilibrium_separation: Quantity
    """Separation z_0 of the surfaces at equilibrium, about the range of the attraction: with the size of the grains
    it determines whether their adhesion is close to JKR or to DMT; with normal = "jkr-dmt". (from 1e-11 m to 1e-6
    m, or a number in m)
    """
    friction: Quantity
    """Coefficient of friction mu between grains, in the test. (from 0 to 10)"""
    hamaker_constant: Quantity
    """Hamaker's constant A of the material of the grains in their medium; with adhesion = "van-der-waals". (from 0 J
    to 1e-17 J, or a number in J)
    """
    interface_energy: Quantity
    """Interface energy Gamma: work of adhesion per area, used by normal = "jkr", "dmt" and "jkr-dmt"; 0 is no
    adhesion. (from 0 J/m2 to 100 J/m2, or a number in J/m2)
    """
    largest_bridge_volume: Quantity
    """Largest volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j), where the films have that much
    liquid; with adhesion = "capillary-bridge-films". (from 1e-6 to 0.1)
    """
    least_separation: Quantity
    """Gap D_0 of the surfaces below which their attraction is constant, also for touching grains; with adhesion =
    "van-der-waals". (from 1e-11 m to 1e-6 m, or a number in m)
    """
    liquid_content: Quantity
    """Volume of the liquid on a grain at the start over the volume of the grain; with adhesion =
    "capillary-bridge-films". (from 0 to 0.3)
    """
    normal_stiffness: Quantity
    """Stiffness k_n of the linear spring of every contact; at first loading where contacts are plastic; with normal
    = "hooke" or normal = "luding". (from 1 N/m to 1e10 N/m, or a number in N/m)
    """
    plasticity_depth: Quantity
    """Plastic overlap phi_f beyond which contacts are elastic, over 2 R_i R_j / (R_i + R_j); with normal = "luding".
    (from 1e-6 to 0.5)
    """
    rolling_damping: Quantity
    """Fraction zeta_r of critical damping of the rolling spring below its limit; with rolling = "elastic-plastic" or
    rolling = "elastic-plastic-twisting". (from 0 to 1)
    """
    rolling_friction: Quantity
    """Coefficient mu_r of rolling friction: the rolling couple is at most mu_r R* N; with rolling =
    "elastic-plastic" or rolling = "elastic-plastic-twisting" or rolling = "spring-dashpot-slider". (from 0 to 2)
    """
    rolling_stiffness: Quantity
    """Stiffness k_r of the rolling spring of every contact, relative to the displacement R* times the angle of
    rolling; with rolling = "spring-dashpot-slider". (from 0.001 N/m to 1e10 N/m, or a number in N/m)
    """
    rolling_viscosity: Quantity
    """Coefficient gamma_r of the rolling dashpot of every contact, relative to R* times the rate of rolling; with
    rolling = "spring-dashpot-slider". (from 0 N s/m to 1000000 N s/m, or a number in N s/m)
    """
    roughness: Quantity
    """Root mean square roughness S_q of the surface of a grain; that of a contact is (S_i^2 + S_j^2)^(1/2); with
    normal = "rough-hertz". (from 0 m to 1e-4 m, or a number in m)
    """
    rupture_coefficient: Quantity
    """Coefficient c of the rupture distance R_e (1 + theta/2) (v^(1/3) + c v^(2/3)), v = V/R_e^3: 0.1 of Willett et
    al. 2000, 0 of Lian et al. 1993; with adhesion = "capillary-bridge" or adhesion = "capillary-bridge-films".
    (from 0 to 1)
    """
    surface_tension: Quantity
    """Surface tension gamma of the liquid of the bridges; with adhesion = "capillary-bridge" or adhesion =
    "capillary-bridge-films". (from 0 N/m to 10 N/m, or a number in N/m)
    """
    tangential_stiffness_ratio: Quantity
    """Tangential stiffness over the normal stiffness, k_t/k_n, for a normal law without contact area; with
    tangential = "no-slip". (from 0 to 1)
    """
    twisting_damping: Quantity
    """Fraction zeta_t of critical damping of the twisting spring below its limit; with rolling =
    "elastic-plastic-twisting". (from 0 to 1)
    """
    twisting_friction: Quantity
    """Coefficient mu_t of twisting friction: the couple about the normal is at most mu_t R* N; with rolling =
    "elastic-plastic-twisting". (from 0 to 2)
    """
    unloading_ratio: Quantity
    """Stiffness k_p of the hardest unloading over that of first loading, contact.normal_stiffness; with normal =
    "luding". (from 1.001 to 1000)
    """


class Preparation(TypedDict, total=False):
    """The sample: a loose initial state of grains that do not touch, placed at random from a seed, compressed
    isotropically and relaxed with the final properties.
    """

    bedding_spread: Quantity
    """Standard deviation of the angle between the long axes and their layer; only with bedding_tilt. (from 0 deg to
    60 deg, or a number in rad) Default: 15 deg.
    """
    bedding_tilt: Quantity
    """Angle between the normal of the layers in which grains that are not spheres were deposited and axis 1, in the
    plane of the axes 1 and 2: long axes lie in the layers. (from 0 deg to 90 deg, or a number in rad) Default:
    none.
    """
    compaction_stress: Quantity
    """Mean stress while compacting, from which the sample is brought to mean_stress: a smaller one makes looser
    samples. (from 1e-6 Pa to 100 GPa, or a number in Pa) Default: auto.
    """
    cycle_strain: Quantity
    """Amplitude of the axial strain of these cycles. (from 1e-5 to 0.2) Default: 0.01."""
    cycles: Quantity
    """Number of cycles of axial strain at constant mean stress after the compaction. They make dense samples. (from
    0 to 100000) Default: 0.0.
    """
    densest_void_ratio: Quantity
    """Void ratio e_min of the densest state, which `granum limits` finds. (from 0.05 to 2) Default: none."""
    friction: Quantity
    """Coefficient of friction while compacting. (from 0 to 10) Default: auto."""
    inertial_number: Quantity
    """Highest inertial number I while compressing, once grains carry load. (from 1e-7 to 0.1) Default: 0.001."""
    initial_solid_fraction: Quantity
    """Solid fraction of the loose initial state, in which no grains touch. (from 0.01 to 0.5) Default: 0.35."""
    interface_energy: Quantity
    """Interface energy while compacting; contacts of normal = "hertz" follow JKR meanwhile. (from 0 J/m2 to 100
    J/m2, or a number in J/m2) Default: 0 J/m2.
    """
    loosest_void_ratio: Quantity
    """Void ratio e_max of the loosest state, which `granum limits` finds. (from 0.05 to 3) Default: none."""
    mean_stress: Quantity
    """Target mean stress p. (from 0.001 Pa to 100 GPa, or a number in Pa) Default: 20 kPa."""
    relative_density: Quantity
    """Target relative density (e_max - e)/(e_max - e_min), in place of solid_fraction; it needs the two void ratios
    below. (from -0.5 to 1.5) Default: none.
    """
    rolling_friction: Quantity
    """Coefficient of rolling friction while compacting, also where the contact law has none. (from 0 to 2) Default:
    auto.
    """
    seed: Quantity
    """Seed of the loose initial state: another seed is another sample of the same material. (from 0 to
    9223372036854775807) Default: 1.0.
    """
    solid_fraction: Quantity
    """Target solid fraction of the sample. (from 0.3 to 0.8) Default: 0.61."""
    solid_fraction_tolerance: Quantity
    """Accepted deviation from the target solid fraction. (from 0.0001 to 0.1) Default: 0.005."""
    stage: Sequence["Stage"]
    """Loading paths between the compaction of the sample and its relaxation; they record nothing and start where the
    one before ended.
    """
    unbalanced_force: Quantity
    """The sample is at rest when the unbalanced force is below this fraction of the mean contact force. (from 1e-9
    to 0.1) Default: 0.001.
    """
    void_ratio: Quantity
    """Target void ratio e of the sample, in place of solid_fraction = 1/(1 + e). (from 0.2 to 2) Default: none."""


class Recording(TypedDict, total=False):
    """The states that the sensors record, and the bins of the force distribution P(f)."""

    bin_width: Quantity
    """Width of a bin of f = N/<N>. (from 0.001 to 10) Default: 0.25."""
    critical_exponent: Quantity
    """Exponent of the mean stress in the critical state line; of the sensor state_parameter. (from 0.01 to 10)
    Default: none.
    """
    critical_slope: Quantity
    """Decrease of the critical void ratio from zero mean stress to 100 kPa; of the sensor state_parameter. (from 0
    to 10) Default: none.
    """
    critical_void_ratio: Quantity
    """Critical void ratio e_0 at zero mean stress: e_c = e_0 - critical_slope (p / 100 kPa)^critical_exponent; of
    the sensor state_parameter. (from 0.01 to 10) Default: none.
    """
    first_strain: Quantity
    """Deviator strain of the first state after the start: states are then spaced from there to the end by a constant
    factor. (from 1e-9 to 3) Default: none.
    """
    largest_force: Quantity
    """Largest f with a bin of its own; larger forces are counted separately. (from 0.1 to 1000) Default: 6.0."""
    observations_per_state: Quantity
    """Observations averaged for one recorded state, spread evenly over one interval of strain around it. (from 1 to
    100000) Default: 20.0.
    """
    sensors: Sequence[str] | Literal["none"]
    """Sensors that are recorded in addition to the usual ones, e.g. ["overlap_distribution"]; `granum measure
    --list` shows all. Default: none.
    """
    snapshots: Quantities | Literal["none"]
    """Deviator strains at which all grains and contacts are saved, in addition to the start and the end, e.g. [0.01,
    0.1]. Default: none.
    """
    states: Quantity
    """Number of equal intervals of deviator strain; a state is recorded at each end of an interval. (from 1 to
    1000000) Default: 120.0.
    """
    strains: Quantities | Literal["none"]
    """Deviator strains at which a state is recorded, instead of states and first_strain, e.g. [1e-5, 1e-4, 1e-3,
    0.01, 0.1]. Default: none.
    """


class Shear(TypedDict, total=False):
    """The test: axisymmetric compression at constant mean stress."""

    density_scaling: Quantity
    """Factor on the density of every grain; only together with strain_rate. (from 1e-6 to 1e24) Default:
    1000000000000.0.
    """
    deviator_strain: Quantity
    """Deviator strain eps_1 - eps_3 at the end. (from 1e-6 to 3) Default: 0.3."""
    inertial_number: Quantity
    """Speed: inertial number I = strain_rate d sqrt(density / p) of the axial strain rate. Without gravity only I
    matters. (from 1e-8 to 0.1) Default: 0.000364.
    """
    mean_stress: Quantity
    """Mean stress p held constant. (from 0.001 Pa to 100 GPa, or a number in Pa) Default: sample."""
    strain_rate: Quantity
    """Axial strain rate, which can be given instead of inertial_number. The paper's 1e-5 /s with density_scaling =
    1e12 gives the I above. (from 1e-12 /s to 1e6 /s, or a number in 1/s) Default: 1e-5 /s.
    """


class ConstantPStage(TypedDict, total=False):
    """Axisymmetric compression or extension at constant mean stress: the test of Antony, Zhou and Wang (2006)."""

    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    deviator_strain: Quantity
    """Deviator strain eps_1 - eps_3 at the end; negative for extension along x. (from -3 to 3) Default: 0.3."""
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    mean_stress: Quantity
    """Mean stress p, to which the sample is consolidated first and which is then held. (from 0.001 Pa to 1e11 Pa, or
    a number in Pa) If left out: that of the sample.
    """
    path: Literal["constant-p"]
    """Axisymmetric compression or extension at constant mean stress: the test of Antony, Zhou and Wang (2006)."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class IsotropicStage(TypedDict, total=False):
    """Isotropic compression or unloading: all three axes are brought to one stress, at which the sample comes to
    rest; then to a second stress if one is given.
    """

    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    interval: Quantity
    """Arc length of strain between recorded states. (from 1e-7 to 1) Default: 0.0001."""
    mean_stress: Quantity
    """Stress to which all three axes are brought; negative for tension. (from -1e11 Pa to 1e11 Pa, or a number in
    Pa) Default: 100000.0.
    """
    path: Literal["isotropic"]
    """Isotropic compression or unloading: all three axes are brought to one stress, at which the sample comes to
    rest; then to a second stress if one is given.
    """
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    unloading_stress: Quantity
    """Stress to which all three axes are brought afterwards. (from -1e11 Pa to 1e11 Pa, or a number in Pa) If left
    out: no unloading.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class DrainedTriaxialStage(TypedDict, total=False):
    """Drained triaxial compression or extension: axis x is strained, the stresses along y and z are held."""

    axial_strain: Quantity
    """Axial strain at the end; negative for extension. (from -3 to 3) Default: 0.2."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    lateral_stress: Quantity
    """Stress along y and z, to which the sample is first consolidated on all three axes. (from -1e11 Pa to 1e11 Pa,
    or a number in Pa) If left out: that of the sample.
    """
    path: Literal["drained-triaxial"]
    """Drained triaxial compression or extension: axis x is strained, the stresses along y and z are held."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class UndrainedTriaxialStage(TypedDict, total=False):
    """Undrained triaxial compression or extension: axis x is strained at constant volume. The stresses are effective
    ones.
    """

    axial_strain: Quantity
    """Axial strain at the end; negative for extension. (from -3 to 3) Default: 0.2."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    fluid_modulus: Quantity
    """Bulk modulus of the pore fluid over the porosity, K_f / n. (from 0.001 Pa to 1e11 Pa, or a number in Pa) If
    left out: the fluid is incompressible, and the volume of the sample is constant.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    mean_stress: Quantity
    """Mean effective stress to which the sample is consolidated first. (from 0.001 Pa to 1e11 Pa, or a number in Pa)
    If left out: that of the sample.
    """
    path: Literal["undrained-triaxial"]
    """Undrained triaxial compression or extension: axis x is strained at constant volume. The stresses are effective
    ones.
    """
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class ConstantPAndBStage(TypedDict, total=False):
    """True triaxial test: axis x is strained at constant mean stress p and constant b = (sigma_y - sigma_z) /
    (sigma_x - sigma_z).
    """

    axial_strain: Quantity
    """Strain along x, the axis of the major stress, at the end. (from 1e-6 to 3) Default: 0.1."""
    b: Quantity
    """Intermediate stress ratio: 0 is triaxial compression, 1 triaxial extension. (from 0 to 1) Default: 0.5."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of 1 + b times the strain rate along x, at least the rate of the fastest axis. (from
    1e-8 to 0.1) Default: 0.001.
    """
    mean_stress: Quantity
    """Mean stress p, to which the sample is consolidated first and which is then held. (from 0.001 Pa to 1e11 Pa, or
    a number in Pa) If left out: that of the sample.
    """
    path: Literal["constant-p-and-b"]
    """True triaxial test: axis x is strained at constant mean stress p and constant b = (sigma_y - sigma_z) /
    (sigma_x - sigma_z).
    """
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class OedometerStage(TypedDict, total=False):
    """Oedometer: axis x is compressed without lateral strain up to a stress, and unloaded if a second is given."""

    axial_stress: Quantity
    """Stress along x at the end of the loading. (from 0.001 Pa to 1e11 Pa, or a number in Pa) Default: 1000000.0."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    interval: Quantity
    """Arc length of strain between recorded states, which is sqrt(2/3) of the axial strain. (from 1e-7 to 1)
    Default: 0.0001.
    """
    path: Literal["oedometer"]
    """Oedometer: axis x is compressed without lateral strain up to a stress, and unloaded if a second is given."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    unloading_stress: Quantity
    """Stress along x at the end of the unloading. (from -1e11 Pa to 1e11 Pa, or a number in Pa) If left out: no
    unloading.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class SimpleShearStage(TypedDict, total=False):
    """Simple shear in the plane xy at constant normal stress along y, without strain along x and z."""

    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    normal_stress: Quantity
    """Stress along y, to which the sample is first consolidated on all three axes. (from 0.001 Pa to 1e11 Pa, or a
    number in Pa) If left out: that of the sample.
    """
    path: Literal["simple-shear"]
    """Simple shear in the plane xy at constant normal stress along y, without strain along x and z."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    shear_strain: Quantity
    """Shear strain gamma_xy at the end. (from 1e-6 to 1) Default: 0.3."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class SimpleShearConstantVolumeStage(TypedDict, total=False):
    """Simple shear in the plane xy at constant volume: an undrained simple shear test."""

    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    mean_stress: Quantity
    """Mean stress to which the sample is consolidated first. (from 0.001 Pa to 1e11 Pa, or a number in Pa) If left
    out: that of the sample.
    """
    path: Literal["simple-shear-constant-volume"]
    """Simple shear in the plane xy at constant volume: an undrained simple shear test."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    shear_strain: Quantity
    """Shear strain gamma_xy at the end. (from 1e-6 to 1) Default: 0.3."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class PlaneStrainStage(TypedDict, total=False):
    """Plane strain compression or extension: axis x is strained, axis y does not strain, the stress along z is held."""

    axial_strain: Quantity
    """Strain along x at the end; negative for extension. (from -3 to 3) Default: 0.2."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    lateral_stress: Quantity
    """Stress along z, to which the sample is first consolidated on all three axes. (from 0.001 Pa to 1e11 Pa, or a
    number in Pa) If left out: that of the sample.
    """
    path: Literal["plane-strain"]
    """Plane strain compression or extension: axis x is strained, axis y does not strain, the stress along z is held."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class ProportionalStage(TypedDict, total=False):
    """Proportional loading: the strains along y and z are constant multiples of that along x; or the stresses are,
    which are first brought to these ratios at constant mean stress.
    """

    axial_strain: Quantity
    """Strain along x at the end; negative for unloading. (from -3 to 3) Default: 0.01."""
    axial_stress: Quantity
    """Stress along x at which the path ends, if it is reached before axial_strain. (from 0.001 Pa to 1e11 Pa, or a
    number in Pa) If left out: the path ends at axial_strain.
    """
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    mean_stress: Quantity
    """Mean stress to which the sample is consolidated first. (from 0.001 Pa to 1e11 Pa, or a number in Pa) If left
    out: that of the sample.
    """
    path: Literal["proportional"]
    """Proportional loading: the strains along y and z are constant multiples of that along x; or the stresses are,
    which are first brought to these ratios at constant mean stress.
    """
    ratio_y: Quantity
    """Strain or stress along y over that along x. (from -3 to 3) Default: 0.6."""
    ratio_z: Quantity
    """Strain or stress along z over that along x. (from -3 to 3) Default: 0.6."""
    ratios_of: Literal["strain", "stress"]
    """What has constant ratios. strain: strain increments; stress: stresses Default: strain."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class CyclicStage(TypedDict, total=False):
    """Cyclic triaxial test between two axial strains or two deviator stresses, drained or undrained: a number of
    cycles, or until liquefaction or a double amplitude of strain.
    """

    cycles: Quantity
    """Number of cycles. (from 1 to 1000000) Default: 10.0."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    double_amplitude: Quantity
    """Axial strain since the last turning point at which a test with stress_amplitude ends. (from 1e-5 to 1)
    Default: 0.05.
    """
    drainage: Literal["undrained", "drained"]
    """Control of the lateral axes. undrained: the volume is constant; stresses are effective stresses; drained: the
    lateral stresses are held Default: undrained.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    interval: Quantity
    """Arc length of strain between recorded states. (from 1e-7 to 1) If left out: a fortieth of a strain cycle with
    strain_amplitude, 1e-4 with stress_amplitude.
    """
    mean_deviator_stress: Quantity
    """Deviator stress in the middle of the cycles of stress_amplitude. (from -1e11 Pa to 1e11 Pa, or a number in Pa)
    Default: 0.0.
    """
    mean_strain: Quantity
    """Axial strain in the middle of the cycles. (from -1 to 1) Default: 0.0."""
    mean_stress: Quantity
    """Mean effective stress to which the sample is consolidated first. (from 0.001 Pa to 1e11 Pa, or a number in Pa)
    If left out: that of the sample.
    """
    path: Literal["cyclic"]
    """Cyclic triaxial test between two axial strains or two deviator stresses, drained or undrained: a number of
    cycles, or until liquefaction or a double amplitude of strain.
    """
    pore_pressure_ratio: Quantity
    """Ratio r_u = 1 - p/p_0 of the excess pore pressure at which an undrained test ends: liquefaction. (from 0.01 to
    1) Default: 0.95.
    """
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    strain_amplitude: Quantity
    """Axial strain between the middle of a cycle and its turning points. (from 1e-7 to 0.5) Default: 0.001."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    stress_amplitude: Quantity
    """Deviator stress sigma_x - sigma_y between the middle of a cycle and its turning points, instead of
    strain_amplitude. (from 0.001 Pa to 1e11 Pa, or a number in Pa) If left out: the turning points are given by
    strain_amplitude.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class UnloadReloadStage(TypedDict, total=False):
    """Drained triaxial compression along x in which the deviator stress is removed and reapplied at given strains."""

    at: Quantities
    """Axial strains at which the sample is unloaded; those beyond axial_strain are ignored. Default: [0.01, 0.03,
    0.06].
    """
    axial_strain: Quantity
    """Axial strain at the end. (from 1e-6 to 3) Default: 0.1."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    lateral_stress: Quantity
    """Stress along y and z, to which the sample is first consolidated on all three axes. (from 0.001 Pa to 1e11 Pa,
    or a number in Pa) If left out: that of the sample.
    """
    path: Literal["unload-reload"]
    """Drained triaxial compression along x in which the deviator stress is removed and reapplied at given strains."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    unloaded_deviator_stress: Quantity
    """Deviator stress sigma_x - sigma_y at the end of an unloading. (from -1e11 Pa to 1e11 Pa, or a number in Pa)
    Default: 0.0.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class UnconfinedStrengthStage(TypedDict, total=False):
    """Unconfined yield strength of a powder: consolidation, compression along x to steady flow at the lateral stress
    (pre-shear), unloading to zero stress, and compression along x without lateral stress until it fails.
    """

    axial_strain: Quantity
    """Axial strain at the end of the unconfined compression. (from 1e-6 to 3) Default: 0.1."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the axial strain rate, at the mean stress at the start of the pre-shear, and at a
    twentieth of the lateral stress in the unconfined compression. (from 1e-8 to 0.1) Default: 0.001.
    """
    lateral_stress: Quantity
    """Stress along y and z in the pre-shear, to which the sample is first consolidated on all three axes. (from
    0.001 Pa to 1e11 Pa, or a number in Pa) Default: 10000.0.
    """
    path: Literal["unconfined-strength"]
    """Unconfined yield strength of a powder: consolidation, compression along x to steady flow at the lateral stress
    (pre-shear), unloading to zero stress, and compression along x without lateral stress until it fails.
    """
    pre_shear_strain: Quantity
    """Axial strain of the pre-shear. (from 1e-6 to 3) Default: 0.3."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals; a state is recorded at the end of each. (from 1 to 1000000) Default: 100.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class HoldStage(TypedDict, total=False):
    """All stresses are held (creep), or all strains (relaxation), until the sample is at rest or for a given time."""

    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    duration: Quantity
    """Simulated time for which they are held. (from 1e-15 s to 1e9 s, or a number in s) If left out: until the
    sample is at rest.
    """
    held: Literal["stress", "strain"]
    """What is held constant. stress: all six stresses; any strain is creep; strain: all strains; the stresses relax
    Default: stress.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.001.
    """
    interval: Quantity
    """Arc length of strain between recorded states. (from 1e-7 to 1) Default: 0.0001."""
    path: Literal["hold"]
    """All stresses are held (creep), or all strains (relaxation), until the sample is at rest or for a given time."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    states: Quantity
    """Number of equal intervals of the duration; a state is recorded at the end of each. (from 1 to 1000000)
    Default: 20.0.
    """
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    unbalanced_force: Quantity
    """Unbalanced force over the mean contact force below which the sample is at rest. (from 1e-9 to 1) Default:
    0.001.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class HistoryStage(TypedDict, total=False):
    """Strains or stresses from a CSV file, row by row: the cell follows straight lines between the rows."""

    columns: Quantities
    """Names of the columns, if the case contains the rows."""
    compression: Literal["positive", "negative"]
    """Sign of compression in the file. positive: as in granum and soil mechanics; negative: as in most
    finite-element programs Default: positive.
    """
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    file: str
    """CSV file with columns among xx_strain, yy_strain, zz_strain, yz_strain, zx_strain, xy_strain and the same with
    _stress, with units as in `xx_stress (kPa)`; strains are logarithmic and count from the start of the path. A
    column time is accepted but not used: the response of the grains does not depend on it.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the largest strain rate at the mean stress at the start of each row. For stresses
    the strain is estimated from the contacts. (from 1e-8 to 0.1) Default: 0.001.
    """
    interval: Quantity
    """Arc length of strain between the states that are recorded between the rows. (from 1e-7 to 1) If left out: at
    the rows only.
    """
    path: Literal["history"]
    """Strains or stresses from a CSV file, row by row: the cell follows straight lines between the rows."""
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    rows: Quantities
    """The rows, instead of a file."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class RandomStage(TypedDict, total=False):
    """Deviatoric strains along a path of straight lines that a seed decides, at constant or changing mean stress or
    at constant volume: turning points anywhere, one line, cycles, or all of them in turn.
    """

    amplitude: Quantity
    """Largest deviatoric strain sqrt(2/3 e:e) from the start of the path. (from 1e-6 to 1) Default: 0.01."""
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    drainage: Literal["drained", "undrained", "moving"]
    """What happens to the volume and the mean stress. drained: the mean stress is held and the volume is free;
    undrained: the volume is constant; moving: along each line the mean stress goes to a random value from
    lowest_mean_stress to highest_mean_stress, of uniform density in its logarithm Default: drained.
    """
    highest_mean_stress: Quantity
    """Highest mean stress of a turning point, where the mean stress moves. (from 0.001 Pa to 1e11 Pa, or a number in
    Pa) Default: 500000.0.
    """
    inertial_number: Quantity
    """Speed: inertial number I of the rate of the deviatoric strain at the mean stress at the start of each line,
    undrained at mean_stress. (from 1e-8 to 0.1) Default: 0.001.
    """
    interval: Quantity
    """Arc length of strain between the states that are recorded along a line; the turning points are recorded too.
    (from 1e-7 to 1) Default: 0.001.
    """
    kind: Literal["random", "monotonic", "cyclic", "mixed"]
    """What the path consists of. random: straight lines between points anywhere in the ball of all deviatoric
    strains up to amplitude; monotonic: one straight line in a random direction; cyclic: cycles in a random
    direction, with an amplitude between a quarter of amplitude and amplitude; mixed: random points, points at the
    amplitude, and one to three small cycles, in random order Default: random.
    """
    length: Quantity
    """Length of the path: the sum of sqrt(2/3 de:de) over its lines. (from 1e-6 to 100) Default: 0.1."""
    lowest_mean_stress: Quantity
    """Lowest mean stress of a turning point, where the mean stress moves. (from 0.001 Pa to 1e11 Pa, or a number in
    Pa) Default: 20000.0.
    """
    mean_stress: Quantity
    """Mean stress p, to which the sample is consolidated first and which is then held, unless drainage says
    otherwise. (from 0.001 Pa to 1e11 Pa, or a number in Pa) If left out: that of the sample.
    """
    path: Literal["random"]
    """Deviatoric strains along a path of straight lines that a seed decides, at constant or changing mean stress or
    at constant volume: turning points anywhere, one line, cycles, or all of them in turn.
    """
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    seed: Quantity
    """Whole number that decides the path. (from 0 to 9e15) Default: 1.0."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class ProbesStage(TypedDict, total=False):
    """Small increments of strain or stress in many directions, each from the same state at rest: the response
    envelope.
    """

    around: Literal["triaxial-plane", "components"]
    """Directions of the probes. triaxial-plane: equal angles in the plane of the axial and the two equal lateral
    components; components: each of the six components in both senses, for the tangent stiffness Default:
    triaxial-plane.
    """
    density_scaling: Quantity
    """Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.
    (from 1e-6 to 1e24) If left out: 1.
    """
    directions: Quantity
    """Number of directions in the triaxial plane. (from 1 to 360) Default: 12.0."""
    inertial_number: Quantity
    """Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage. (from 1e-8
    to 0.1) Default: 0.0001.
    """
    path: Literal["probes"]
    """Small increments of strain or stress in many directions, each from the same state at rest: the response
    envelope.
    """
    resets: bool
    """False if strain, time and energy continue to count from an earlier stage. Default: True."""
    strain: Quantity
    """Length of the strain increments; shear strains are angles. (from 1e-9 to 0.01) Default: 1e-05."""
    strain_rate: Quantity
    """Driving strain rate, which can be given instead of inertial_number. (from 1e-12 1/s to 1e9 1/s, or a number in
    1/s) If left out: given by inertial_number.
    """
    stress: Quantity
    """Length of the stress increments, instead of strain. (from 0.001 Pa to 1e11 Pa, or a number in Pa) If left out:
    increments of strain.
    """
    unbalanced_force: Quantity
    """Unbalanced force over the mean contact force below which the sample is at rest before the probes. (from 1e-9
    to 1) Default: 0.0001.
    """
    until: dict[str, Any]
    """End conditions in addition to those of the path, as a stage with an explicit control has them, where the path
    has one stage that is driven, e.g. { mean_stress = "10 kPa" }.
    """


class RepeatedStage(TypedDict, total=False):
    """A sequence of stages that is repeated."""

    repeat: int
    """Number of repetitions."""
    stage: Sequence["Stage"]
    """The repeated stages."""


class IncrementalDriverStage(TypedDict, total=False):
    """The steps of an IncrementalDriver file."""

    incremental_driver: Quantity
    """A loading path (test.inp) of Niemunis' IncrementalDriver, whose steps become stages."""
    inertial_number: Quantity
    """Speed of its stages: inertial number of the largest strain rate."""
    interval: Quantity
    """Arc length of strain between recorded states."""
    stress_unit: Quantity
    """The unit of stress of that file, e.g. "1 kPa"."""


class ControlledStageRecord(TypedDict, total=False):
    """The states that are recorded: { measure = ..., every = ... }, { ..., states = ..., end = ... } or { ..., at =
    [...] }.
    """

    measure: Literal["arc_length", "time", "xx_strain", "yy_strain", "zz_strain", "yz_strain", "zx_strain", "xy_strain", "deviator_strain", "volumetric_strain", "deviatoric_strain", "xx_stress", "yy_stress", "zz_stress", "yz_stress", "zx_stress", "xy_stress", "mean_stress", "deviator_stress", "axial_deviator_stress", "stress_ratio"]
    """"""


class ControlledStageTurns(TypedDict, total=False):
    """Turning points of a cyclic stage: { measure = ..., high = ..., low = ... }."""

    measure: Literal["arc_length", "time", "xx_strain", "yy_strain", "zz_strain", "yz_strain", "zx_strain", "xy_strain", "deviator_strain", "volumetric_strain", "deviatoric_strain", "xx_stress", "yy_stress", "zz_stress", "yz_stress", "zx_stress", "xy_stress", "mean_stress", "deviator_stress", "axial_deviator_stress", "stress_ratio"]
    """"""


class ControlledStageUntil(TypedDict, total=False):
    """End conditions, the first of which to be met ends the stage: measures with values, reversals, ramp_over,
    pore_pressure_ratio, double_amplitude, unbalanced_force, critical_state.
    """

    arc_length: Quantity
    """"""
    axial_deviator_stress: Quantity
    """"""
    critical_state: dict[str, Any]
    """"""
    deviator_strain: Quantity
    """"""
    deviator_stress: Quantity
    """"""
    deviatoric_strain: Quantity
    """"""
    double_amplitude: dict[str, Any]
    """"""
    mean_stress: Quantity
    """"""
    pore_pressure_ratio: Quantity
    """"""
    ramp_over: bool
    """"""
    reversals: int
    """"""
    stress_ratio: Quantity
    """"""
    time: Quantity
    """"""
    unbalanced_force: Quantity
    """"""
    volumetric_strain: Quantity
    """"""
    xx_strain: Quantity
    """"""
    xx_stress: Quantity
    """"""
    xy_strain: Quantity
    """"""
    xy_stress: Quantity
    """"""
    yy_strain: Quantity
    """"""
    yy_stress: Quantity
    """"""
    yz_strain: Quantity
    """"""
    yz_stress: Quantity
    """"""
    zx_strain: Quantity
    """"""
    zx_stress: Quantity
    """"""
    zz_strain: Quantity
    """"""
    zz_stress: Quantity
    """"""


class ControlledStage(TypedDict, total=False):
    """A stage with an explicit control."""

    constraint: Sequence[dict[str, Any]]
    """Combinations of stresses or of strain rates that are controlled, as a list of tables."""
    density_scaling: Quantity
    """Factor on the density of every grain in this stage; only together with strain_rate."""
    inertial_number: Quantity
    """Speed: the strain rate that counts as 1, as an inertial number at the mean stress at the start of the stage."""
    kinematics: Literal["pure-shear", "simple-shear"]
    """How shear rates move the cell: "pure-shear" or "simple-shear"."""
    most_arc_length: Quantity
    """Arc length of strain after which the stage ends in any case."""
    name: str
    """A name, for the reader."""
    record: ControlledStageRecord
    """The states that are recorded: { measure = ..., every = ... }, { ..., states = ..., end = ... } or { ..., at =
    [...] }.
    """
    resets: bool
    """True if strain, time and energy count from the start of this stage."""
    servo_limit: Quantity
    """Bound on the strain rate that the servo adds for one controlled stress, as a multiple of the rate that counts
    as 1.
    """
    servo_response: Quantity
    """Time constant of the servo, in time steps."""
    settling: bool
    """True if velocities are damped globally, so that the sample comes to rest."""
    start: Literal["here", "kept", "back"]
    """Initial state. "here": where the stage before ended; "kept": the same, and later stages can go back to it;
    "back": the state that was kept last.
    """
    strain_rate: Quantity
    """Speed, instead of inertial_number: the strain rate that counts as 1."""
    turns: ControlledStageTurns
    """Turning points of a cyclic stage: { measure = ..., high = ..., low = ... }."""
    until: ControlledStageUntil
    """End conditions, the first of which to be met ends the stage: measures with values, reversals, ramp_over,
    pore_pressure_ratio, double_amplitude, unbalanced_force, critical_state.
    """
    xx: Literal["fixed", "free"] | dict[str, Any]
    """Control of this component: "fixed", "free", { rate = ... }, { stress = ... }, { stress_rate = ... }, or a ramp
    { strain_to = ... }, { strain_by = ... }, { stress_to = ... }, { stress_by = ... }.
    """
    xy: Literal["fixed", "free"] | dict[str, Any]
    """As xx."""
    yy: Literal["fixed", "free"] | dict[str, Any]
    """As xx."""
    yz: Literal["fixed", "free"] | dict[str, Any]
    """As xx; shear strains are angles."""
    zx: Literal["fixed", "free"] | dict[str, Any]
    """As xx."""
    zz: Literal["fixed", "free"] | dict[str, Any]
    """As xx."""


Stage: TypeAlias = (
    ConstantPStage
    | IsotropicStage
    | DrainedTriaxialStage
    | UndrainedTriaxialStage
    | ConstantPAndBStage
    | OedometerStage
    | SimpleShearStage
    | SimpleShearConstantVolumeStage
    | PlaneStrainStage
    | ProportionalStage
    | CyclicStage
    | UnloadReloadStage
    | UnconfinedStrengthStage
    | HoldStage
    | HistoryStage
    | RandomStage
    | ProbesStage
    | RepeatedStage
    | IncrementalDriverStage
    | ControlledStage
)
"""A stage of a test or of a preparation."""
