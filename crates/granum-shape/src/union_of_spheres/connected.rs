//! Whether spheres hang together.

/// A sphere that is not connected to the first one, if there is one.
pub(crate) fn islands(spheres: &[([f64; 3], f64)]) -> Option<usize> {
    connected(spheres).iter().position(|is| !is)
}

/// True for each sphere that touches the first one, directly or by others.
pub(crate) fn connected(spheres: &[([f64; 3], f64)]) -> Vec<bool> {
    let touch = |a: usize, b: usize| {
        let ((p, r), (q, s)) = (&spheres[a], &spheres[b]);
        let square: f64 = (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum();
        square <= (r + s) * (r + s) * (1.0 + 1e-9)
    };
    let mut connected = vec![false; spheres.len()];
    let mut open = Vec::new();
    if let Some(first) = connected.first_mut() {
        *first = true;
        open.push(0);
    }
    while let Some(a) = open.pop() {
        for b in 0..spheres.len() {
            if !connected[b] && touch(a, b) {
                connected[b] = true;
                open.push(b);
            }
        }
    }
    connected
}
