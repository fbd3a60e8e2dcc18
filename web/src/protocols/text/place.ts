// The places of a text: every map, list and scalar with its start and end.
import { isAlias, isMap, isScalar, isSeq, type CST, type Document, type Node, type Pair } from 'yaml'
import type { Path } from './path'

export type Quote = 'plain' | 'single' | 'double' | 'block'

/** `from..to` is what a replacement replaces: without anchor, tag, comments and final newlines. */
export interface Place {
  kind: 'map' | 'list' | 'scalar' | 'alias' | 'empty'
  from: number
  to: number
  flow: boolean
  quote: Quote
  /** An anchor, an alias or a tag: a form shows it as text. */
  special: boolean
  items: Item[]
}

/** A pair of a map or an item of a list: `start` is its key or its dash, `mark` where a value may be. */
export interface Item {
  key: string | null
  start: number
  keyEnd: number
  mark: number
  end: number
  value: Place
}

/** The places of a document's top value; null for an empty document. */
export function placesOf(doc: Document, text: string): Place | null {
  const top = doc.contents as Node | null
  return top?.range ? placeOf(top, text) : null
}

function placeOf(node: Node, text: string): Place {
  const [from, valueEnd] = node.range ?? [0, 0]
  const special = isAlias(node) || Boolean(node.anchor ?? node.tag)
  const place: Place = { kind: 'scalar', from, to: valueEnd, flow: false, quote: 'plain', special, items: [] }
  if (isAlias(node)) return { ...place, kind: 'alias' }
  if (isScalar(node)) return scalarPlace(place, node.srcToken, text)
  if (isMap(node) || isSeq(node)) {
    place.flow = node.flow === true
    place.kind = isMap(node) ? 'map' : 'list'
    place.items = isMap(node) ? pairs(node.items as Pair<Node, Node | null>[], text) : items(node, text)
    if (!place.flow) place.to = place.items.at(-1)?.end ?? from
  }
  return place
}

function scalarPlace(place: Place, token: CST.Token | undefined, text: string): Place {
  if (place.to <= place.from) return { ...place, kind: 'empty' }
  if (token?.type === 'block-scalar') {
    let to = place.to
    while (to > place.from && '\r\n'.includes(text.charAt(to - 1))) to--
    return { ...place, quote: 'block', to }
  }
  if (token?.type === 'single-quoted-scalar') place.quote = 'single'
  if (token?.type === 'double-quoted-scalar') place.quote = 'double'
  return place
}

function pairs(all: Pair<Node, Node | null>[], text: string): Item[] {
  return all.map(({ key, value, srcToken }) => {
    const start = first(srcToken?.start) ?? key.range?.[0] ?? 0
    const keyEnd = key.range?.[1] ?? start
    const colon = srcToken?.sep?.find((token) => token.type === 'map-value-ind')
    const mark = colon ? colon.offset + 1 : keyEnd
    return { key: isScalar(key) ? String(key.value) : null, start, keyEnd, mark, ...valued(value, mark, text) }
  })
}

function items(list: { items: unknown[]; srcToken?: unknown }, text: string): Item[] {
  const token = list.srcToken as CST.BlockSequence | CST.FlowCollection | undefined
  const block = token?.type === 'block-seq'
  const sources = (token?.items ?? []).filter((one) =>
    block
      ? one.start.some((mark) => mark.type === 'seq-item-ind')
      : one.value ?? one.key ?? one.sep ?? first(one.start) !== undefined,
  )
  return (list.items as Node[]).map((node, i) => {
    const dash = sources[i]?.start.find((mark) => mark.type === 'seq-item-ind')
    const start = dash?.offset ?? first(sources[i]?.start) ?? node.range?.[0] ?? 0
    const mark = dash ? start + 1 : start
    return { key: null, start, keyEnd: mark, mark, ...valued(node, mark, text) }
  })
}

function valued(node: Node | null, mark: number, text: string): { value: Place; end: number } {
  const nothing: Place = { kind: 'empty', from: mark, to: mark, flow: false, quote: 'plain', special: false, items: [] }
  const value = node?.range ? placeOf(node, text) : nothing
  return { value, end: value.kind === 'empty' ? mark : value.to }
}

/** Where an anchor or a tag before a value or key begins; undefined if there is none. */
function first(tokens: CST.SourceToken[] | undefined): number | undefined {
  return tokens?.find((token) => token.type === 'anchor' || token.type === 'tag' || token.type === 'explicit-key-ind')?.offset
}

export function itemAt(place: Place | undefined, part: string | number): Item | undefined {
  if (place?.kind === 'map') return place.items.find((item) => item.key === String(part))
  return place?.kind === 'list' && typeof part === 'number' ? place.items[part] : undefined
}

export function placeAt(root: Place | null, path: Path): Place | undefined {
  return path.reduce<Place | undefined>((place, part) => itemAt(place, part)?.value, root ?? undefined)
}
