//! Clumps: rigid bodies of several pieces. A *body* is what moves (mass, principal inertia, velocity, spin, orientation), a *piece* is what
//! touches: a sphere that is fixed on a body. A body of one piece is a sphere, and has nothing of what is in this folder: its piece is the
//! body.
//!
//! The pieces of clumps are rows among the spheres, so that the neighbour list, the contact laws and their kernels see spheres only. What
//! differs is where their forces go, to the body ([`crate::kernel`]'s stage of clumps), and where their rows come from: a piece at
//! `c = R c_0` from the centre X of its body moves with the velocity `v' + L X + omega x c`; its row has the fluctuating velocity
//! `v' + omega x c - L c`, to which the kernel adds `L x` as for every sphere.
//!
//! Only the centre of a body follows the deformation of the cell, so that the branch vector of a contact, to which stress and the work of
//! the boundary belong, joins the centres of the bodies: `l + c_i - c_j` with the branch l of the pieces and their arms c.

pub(crate) mod clumps;
pub(crate) mod placed;
pub(crate) mod ranks;
pub(crate) mod rotor;
pub(crate) mod time_step;
