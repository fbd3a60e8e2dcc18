// Search, completion and hover: loaded after the text is on the screen.
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from '@codemirror/autocomplete'
import { highlightSelectionMatches, search, searchKeymap } from '@codemirror/search'
import { Prec, type Extension } from '@codemirror/state'
import { keymap } from '@codemirror/view'
import type { Read } from '../text/reading'
import { completionFor } from './completion'
import type { Contracts } from './contracts'
import { hoverFor } from './hover'

export function assist(good: () => Read | null, contracts: Contracts): Extension {
  return [
    search({ top: true }), highlightSelectionMatches(), closeBrackets(), autocompletion({ icons: false }),
    completionFor(() => good()?.data, contracts), hoverFor(good, contracts),
    Prec.high(keymap.of([...closeBracketsKeymap, ...completionKeymap, ...searchKeymap])),
  ]
}
