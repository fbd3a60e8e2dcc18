// Commands to a run need control of the bench: free control is taken under the person's name.
import { useControl } from '../app/control'
import { usePreferences } from '../app/preferences'
import { noAnswer } from '../api/refused'

export interface InControl {
  /** Why control cannot be taken under this name; empty if it can, or is ours. */
  obstacle: (name?: string) => string
  /** Ensures control, or throws a message that says why not. */
  ensure: (name?: string) => Promise<void>
}

export function useInControl(): InControl {
  const control = useControl()
  const preferences = usePreferences()
  const named = (name: string): string => name.trim() || preferences.name.trim()
  function obstacle(name = ''): string {
    const [holder, who] = [control.state.holder, named(name)]
    if (control.mine) return ''
    if (!who) return 'your name is needed, to have control of the bench'
    return holder !== null && holder.toLowerCase() !== who.toLowerCase() ? `${holder} has control of the bench` : ''
  }
  async function ensure(name = ''): Promise<void> {
    if (control.mine) return
    const why = obstacle(name)
    if (why) throw noAnswer('NO_CONTROL', why, control.state.holder ? 'ask for it above, or take over with a reason' : 'press Take control above and enter your name')
    await control.take(named(name))
  }
  return { obstacle, ensure }
}
