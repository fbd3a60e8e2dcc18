// The secret that proves who has control: kept for this tab only, and across a reload.
const KEY = 'labrun.lease'

/** A lease, and the `since` under which it is announced to everyone. */
export interface Lease {
  lease: string
  since: string | null
}

/** What this tab holds, or held last; null if it never did. */
export function leaseOfTab(): Lease | null {
  const kept = sessionStorage.getItem(KEY)
  return kept === null ? null : (JSON.parse(kept) as Lease)
}

/** The secret alone, for the header of a command. */
export function keptLease(): string | null {
  return leaseOfTab()?.lease ?? null
}

/** Keep a lease; null forgets it. */
export function keepLease(lease: Lease | null): void {
  if (lease === null) sessionStorage.removeItem(KEY)
  else sessionStorage.setItem(KEY, JSON.stringify(lease))
}
