"use strict";

// The mechanism in closed form, as delta_cad/mechanism has it: lengths in mm, angles in rad, base frame as there.
const Delta = (() => {
  const UP = [0, 0, 1];
  const SENSES = [[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]];
  const MM_PER_M = 1000;
  const HALVINGS = 40; // of a way in mm: to below what a double resolves of it

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = (k, a) => [k * a[0], k * a[1], k * a[2]];
  const plus = (...all) => all.reduce((a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
  const norm = (a) => Math.sqrt(dot(a, a));
  const unit = (a) => times(1 / norm(a), a);

  // One chain at a position: cosine and sine of the shoulder angle, elbows outwards, and w, the forearm's component
  // along the elbow's direction of motion; null where it cannot be closed.
  function chain(m, p, i) {
    const q = dot(p, m.radial[i]) - (m.base_radius_mm + m.outs_mm[i] - m.platform_radius_mm);
    const t = dot(p, m.tangential[i]);
    const z = p[2];
    const rho2 = q * q + z * z;
    const a = m.upper_arm_mm;
    const along = (rho2 + t * t + a * a - m.forearm_mm * m.forearm_mm) / (2 * a);
    const w2 = rho2 - along * along;
    if (!(w2 >= 0) || !(rho2 > 0)) return null;
    const w = Math.sqrt(w2);
    const cos = (q * along + z * w) / rho2;
    const sin = (z * along - q * w) / rho2;
    const forearm = plus(times(q - a * cos, m.radial[i]), times(t, m.tangential[i]), times(z - a * sin, UP));
    return { cos, sin, w, t, theta: Math.atan2(sin, cos), forearm };
  }

  // The three chains; null where one of them cannot be closed.
  function chains(m, p) {
    const all = [0, 1, 2].map((i) => chain(m, p, i));
    return all.includes(null) ? null : all;
  }

  // Frame with unit x and y axes at an origin, row by row.
  function frame(x, y, o) {
    const z = cross(x, y);
    return [x[0], y[0], z[0], o[0], x[1], y[1], z[1], o[1], x[2], y[2], z[2], o[2], 0, 0, 0, 1];
  }

  // Link -> its frame in the base frame, 16 numbers row by row, as placement.py; null out of reach.
  function links(m, p) {
    const solved = chains(m, p);
    if (!solved) return null;
    const out = { base: frame([1, 0, 0], [0, 1, 0], [0, 0, 0]), platform: frame([1, 0, 0], [0, 1, 0], p) };
    solved.forEach((c, i) => {
      const u = m.radial[i];
      const t = m.tangential[i];
      const shoulder = times(m.base_radius_mm + m.outs_mm[i], u);
      const x = plus(times(c.cos, u), times(c.sin, UP));
      out[`upper_arm_${i}`] = frame(x, t, shoulder);
      const turned = (m.ratio > 1 ? -m.ratio : m.ratio) * c.theta;
      const pinion = plus(times(Math.cos(turned), u), times(Math.sin(turned), UP));
      out[`pinion_${i}`] = frame(pinion, t, plus(times(m.pinion_mm[0] + m.outs_mm[i], u), times(m.pinion_mm[1], UP)));
      const elbow = plus(shoulder, times(m.upper_arm_mm, x));
      const along = unit(c.forearm);
      const across = unit(plus(t, times(-dot(along, t), along)));
      const normal = cross(along, across);
      for (const j of [0, 1]) {
        out[`rod_${i}_${j}`] = frame(along, across, plus(elbow, times((j - 0.5) * m.width_mm, t)));
      }
      const between = unit(plus(times(m.width_mm, t), times(-2 * m.eye_inside_mm, across)));
      m.springs_mm.forEach(([sx, sz], k) => {
        const middle = plus(elbow, times(sx, along), times(sz, normal));
        out[`spring_${i}_${k}`] = frame(cross(between, normal), between, middle);
      });
    });
    return out;
  }

  // Eigenvalues of a symmetric 3 x 3 matrix, ascending, by Jacobi's rotations.
  function eigenvalues(symmetric) {
    const a = symmetric.map((row) => row.slice());
    for (let sweep = 0; sweep < 20; sweep++) {
      for (const [p, q, r] of [[0, 1, 2], [0, 2, 1], [1, 2, 0]]) {
        if (a[p][q] === 0) continue;
        const turn = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const t = (turn < 0 ? -1 : 1) / (Math.abs(turn) + Math.hypot(turn, 1));
        const c = 1 / Math.hypot(t, 1);
        const s = t * c;
        a[p][p] -= t * a[p][q];
        a[q][q] += t * a[p][q];
        a[p][q] = a[q][p] = 0;
        [a[p][r], a[q][r]] = [c * a[p][r] - s * a[q][r], s * a[p][r] + c * a[q][r]];
        a[r][p] = a[p][r];
        a[r][q] = a[q][r];
      }
    }
    return [a[0][0], a[1][1], a[2][2]].sort((x, y) => x - y);
  }

  // Sum of weight * (a b^T + b a^T) / 2 over the chains, and a multiple of the unit matrix.
  function summed(diagonal, pairs) {
    const out = [[diagonal, 0, 0], [0, diagonal, 0], [0, 0, diagonal]];
    for (const [weight, a, b] of pairs) {
      for (let j = 0; j < 3; j++) {
        for (let k = 0; k < 3; k++) out[j][k] += (weight * (a[j] * b[k] + b[j] * a[k])) / 2;
      }
    }
    return out;
  }

  const most = (vectors) => Math.max(...SENSES.map((e) => norm(plus(...vectors.map((v, i) => times(e[i], v))))));

  // Figures at a position: angles in rad, kappa, torque in N m, mass in kg, friction in N, step in mm; null out of
  // reach. What the machine does not tell is null.
  function figures(m, p) {
    const solved = chains(m, p);
    if (!solved) return null;
    const arm = m.upper_arm_mm / MM_PER_M;
    const s = solved.map((c) => times(1 / MM_PER_M, c.forearm));
    const lever = solved.map((c) => (arm * c.w) / MM_PER_M);
    const rows = s.map((v, i) => times(1 / lever[i], v)); // of the inverse Jacobian
    const faces = [cross(s[1], s[2]), cross(s[2], s[0]), cross(s[0], s[1])];
    const columns = faces.map((v, i) => times(lever[i] / dot(s[0], faces[0]), v)); // of the Jacobian
    const gram = eigenvalues(summed(0, rows.map((r) => [1, r, r])));
    const n = rows.map((r) => times(arm, r));
    const elbow = solved.map((c, i) => plus(times(-c.sin, m.radial[i]), times(c.cos, UP)));
    const { carried_kg, elbow_kg, cross_kg, joint_kg_m2 } = m.inertia;
    const at_elbow = elbow_kg + joint_kg_m2 / (arm * arm);
    const pairs = n.flatMap((v, i) => [[at_elbow, v, v], [2 * cross_kg, v, elbow[i]]]);
    let friction = null;
    if (m.friction) {
      const { drive_N_m, upright_N, level_N } = m.friction;
      friction = Math.max(...SENSES.map((e) => {
        const sum = times(drive_N_m, plus(...rows.map((r, i) => times(e[i], r))));
        return Math.hypot(Math.abs(sum[2]) + upright_N, Math.hypot(sum[0], sum[1]) + level_N);
      }));
    }
    const count = m.encoder_count_rad;
    return {
      shoulder: solved.map((c) => c.theta),
      lean: solved.map((c) => Math.asin(c.t / m.forearm_mm)),
      kappa: Math.sqrt(gram[2] / gram[0]),
      torque: columns.map((c) => m.force_N * norm(c)),
      effective_mass: eigenvalues(summed(carried_kg, pairs))[2],
      friction,
      position_step: count === null ? null : MM_PER_M * count * most(columns),
    };
  }

  // Whether the handle can be at a position: chains closed, arms between their stops, rods within their joints' lean.
  function reachable(m, p) {
    const [low, high] = m.shoulder_rad;
    const solved = p[2] > 0 ? chains(m, p) : null;
    const within = (c) => c.theta >= low && c.theta <= high && Math.abs(Math.asin(c.t / m.forearm_mm)) <= m.lean_rad;
    return solved !== null && solved.every(within);
  }

  // The position nearest to a wanted one on the segment to it from a reachable one, by halving; null from none.
  function toward(m, from, wanted) {
    if (reachable(m, wanted)) return wanted;
    if (!reachable(m, from)) return null;
    const at = (share) => from.map((v, k) => v + share * (wanted[k] - v));
    let [inside, outside] = [0, 1];
    for (let step = 0; step < HALVINGS; step++) {
      const middle = (inside + outside) / 2;
      if (reachable(m, at(middle))) inside = middle;
      else outside = middle;
    }
    return at(inside);
  }

  return { links, figures, reachable, toward };
})();
