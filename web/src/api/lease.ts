// The secret that proves who has control: kept for this tab alone, also over a reload.
const KEY = 'labrun.lease'

/** A lease, and the `since` by which everybody is told of it. */
export interface Lease {
  lease: string
  since: string | null
}

/** What this tab holds, or held last; null where it never did. */
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
