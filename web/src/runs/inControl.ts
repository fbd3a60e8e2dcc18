// Commands to a run need control of the bench: free control is taken under the person's name.
import { useControl } from '../app/control'
import { usePreferences } from '../app/preferences'
import { noAnswer } from '../api/refused'

/** Returns a function that ensures control, or throws a message that names its holder. */
export function useInControl(): (name?: string) => Promise<void> {
  const control = useControl()
  const preferences = usePreferences()
  return async (name = '') => {
    if (control.mine) return
    const holder = control.state.holder
    if (holder !== null) {
      throw noAnswer('NO_CONTROL', `${holder} has control of the bench`, 'ask for it above, or take over with a reason')
    }
    const who = name.trim() || preferences.name.trim()
    if (!who) throw noAnswer('NO_CONTROL', 'nobody has control of the bench', 'press Take control above and enter your name')
    await control.take(who)
  }
}
