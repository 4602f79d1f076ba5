// Where the labels of vertices are, so that those of near vertices do not cover one another.

const CORNERS = [[1, -1], [1, 1], [-1, -1], [-1, 1]];

/**
 * The corner at which each point has its label: the one that is farthest from all labels before and
 * from all points.
 * @param points places, or null where there is none
 * @param distance from a point to the middle of its label
 */
export const cornersOf = (points, distance) => {
  const taken = [];
  return points.map((point) => {
    if (!point) return null;
    const others = [...taken, ...points.filter((other) => other && other !== point)];
    const room = ([x, y]) => Math.min(Infinity, ...others.map(([u, v]) =>
      Math.hypot(point[0] + x * distance - u, point[1] + y * distance - v)));
    // Of equally good ones the first: where there is room, labels are above to the right.
    const best = CORNERS.reduce((a, b) =>
      Math.min(room(b), 2 * distance) > Math.min(room(a), 2 * distance) ? b : a);
    taken.push([point[0] + best[0] * distance, point[1] + best[1] * distance]);
    return best;
  });
};
