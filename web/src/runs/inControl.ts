// Whoever commands a run needs control of the bench: free control is taken under the person's name.
import { useControl } from '../app/control'
import { usePreferences } from '../app/preferences'
import { noAnswer } from '../api/refused'

/** Gives a function that makes sure of control, or throws a sentence that says who has it. */
export function useInControl(): (name?: string) => Promise<void> {
  const control = useControl()
  const preferences = usePreferences()
  return async (name = '') => {
    if (control.mine) return
    const holder = control.state.holder
    if (holder !== null) {
      throw noAnswer('NO_CONTROL', `${holder} has control of the bench`, 'ask for it above, or take it over with a reason')
    }
    const who = name.trim() || preferences.name.trim()
    if (!who) throw noAnswer('NO_CONTROL', 'nobody has control of the bench', 'press Take control above and say who you are')
    await control.take(who)
  }
}
