// Three-way merge of two texts line by line; where both changed, a person chooses.

export type Side = 'mine' | 'theirs' | 'both'

export interface Block {
  kind: 'same' | Side | 'conflict'
  base: string[]
  mine: string[]
  theirs: string[]
}

/** The blocks of a three-way comparison; without a base, every difference is a conflict. */
export function compare(base: string | null, mine: string, theirs: string): Block[] {
  const [b, m, t] = [base ?? mine, mine, theirs].map((text) => text.split('\n')) as [string[], string[], string[]]
  const inMine = matches(b, m)
  const inTheirs = matches(b, t)
  const blocks: Block[] = []
  let [i, j, k] = [0, 0, 0]
  const push = (toB: number, toM: number, toT: number): void => {
    add(blocks, b.slice(i, toB), m.slice(j, toM), t.slice(k, toT), base !== null)
    ;[i, j, k] = [toB, toM, toT]
  }
  for (let line = 0; line < b.length; line++) {
    const [inM, inT] = [inMine.get(line), inTheirs.get(line)]
    if (inM === undefined || inT === undefined) continue
    push(line, inM, inT)
    push(line + 1, inM + 1, inT + 1)
  }
  push(b.length, m.length, t.length)
  return blocks
}

function add(blocks: Block[], base: string[], mine: string[], theirs: string[], known: boolean): void {
  if (base.length + mine.length + theirs.length === 0) return
  const [changedM, changedT] = [!same(base, mine), !same(base, theirs)]
  const agreed = same(mine, theirs)
  const kind = agreed && !changedM ? 'same' : agreed ? 'both' : !known ? 'conflict' : changedM && changedT ? 'conflict' : changedM ? 'mine' : 'theirs'
  const last = blocks.at(-1)
  if (last?.kind === kind && kind === 'same') {
    last.base.push(...base)
    last.mine.push(...mine)
    last.theirs.push(...theirs)
  } else blocks.push({ kind, base: [...base], mine: [...mine], theirs: [...theirs] })
}

function same(a: readonly string[], b: readonly string[]): boolean {
  return a.length === b.length && a.every((line, i) => line === b[i])
}

/** Line of `a` -> line of `b`, of a longest common subsequence; equal lines at both ends come first. */
function matches(a: readonly string[], b: readonly string[]): Map<number, number> {
  const found = new Map<number, number>()
  let head = 0
  while (head < a.length && head < b.length && a[head] === b[head]) found.set(head, head++)
  let tail = 0
  while (tail < Math.min(a.length, b.length) - head && a[a.length - 1 - tail] === b[b.length - 1 - tail]) tail++
  for (let i = 1; i <= tail; i++) found.set(a.length - i, b.length - i)
  const [rows, columns] = [a.length - head - tail, b.length - head - tail]
  if (rows * columns > 16_000_000) return found
  const lengths = Array.from({ length: rows + 1 }, () => new Uint32Array(columns + 1))
  const at = (i: number, j: number): number => lengths[i]?.[j] ?? 0
  for (let i = rows - 1; i >= 0; i--) {
    for (let j = columns - 1; j >= 0; j--) {
      const row = lengths[i]
      if (row) row[j] = a[head + i] === b[head + j] ? at(i + 1, j + 1) + 1 : Math.max(at(i + 1, j), at(i, j + 1))
    }
  }
  for (let i = 0, j = 0; i < rows && j < columns; ) {
    if (a[head + i] === b[head + j]) found.set(head + i++, head + j++)
    else if (at(i + 1, j) >= at(i, j + 1)) i++
    else j++
  }
  return found
}

/** The merged text, with the choice for each conflict (by its number among the blocks). */
export function merged(blocks: readonly Block[], chosen: ReadonlyMap<number, Side>): string {
  return blocks
    .flatMap((block, i) => {
      if (block.kind === 'theirs') return block.theirs
      if (block.kind !== 'conflict') return block.mine
      const side = chosen.get(i) ?? 'mine'
      return side === 'both' ? [...block.theirs, ...block.mine] : block[side]
    })
    .join('\n')
}
