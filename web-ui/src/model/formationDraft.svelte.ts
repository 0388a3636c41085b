// The formation and the route an operator is putting together, where the server says its places would be, and what it said to the
// last one sent. Must never decide feasibility or lay out slots: the server's answers are shown as they came.

import { FLAG } from '../protocol/frame';
import { ApiError, endFormation, previewFormation, putFormation, putRoute } from '../protocol/rest';
import type { FormationAnchor, FormationControl, FormationPreview, FormationRequest, HeadingRequest, ReferenceSnapshot, Shape } from '../protocol/types';
import { label, refusalText } from '../protocol/words';
import { anchorText, hasParameter, pathHeading, placed, requestOf, whyNobody } from './formationWords';
import type { Place, Slot } from './formationWords';
import type { Journal } from './journal.svelte';
import { parseOffsets } from './offsets';
import { RouteDraft } from './routeDraft.svelte';
import type { Session } from './session.svelte';
import type { Targets } from './targets.svelte';
import type { VehicleRow } from './vehicleRow.svelte';
import { t } from '../language/language.svelte';
import { figureText } from '../language/units.svelte';

export type Outcome = { tone: 'pending' | 'accepted' | 'refused'; text: string } | null;
export type AnchorKind = FormationAnchor['kind'];

const AVAILABLE = new Set(['holding', 'going_to', 'following', 'leading']);
/** A preview is asked for when the form has been left alone for so long. */
const SETTLE_MS = 200;

export class FormationDraft {
  shape = $state<Shape>('wedge');
  spacingM = $state(5);
  heading = $state<HeadingRequest['kind']>('auto');
  headingDeg = $state(0);
  altitudeStepM = $state(0);
  rotationDeg = $state(0);
  scale = $state(1);
  arcDeg = $state(180);
  /** 0: as the server thinks best. Also for the pitch. */
  layers = $state(0);
  pitchM = $state(0);
  offsetsText = $state('');
  anchor = $state<AnchorKind>('leader');
  place = $state.raw<Place | null>(null);
  placeHeightM = $state<number | null>(null);
  referenceName = $state('');
  control = $state<FormationControl>('slots');
  leader = $state<number | null>(null);
  /** Show where the slots would be on the map: from the first change until it is sent or put away. */
  preview = $state(false);
  /** The server's answer to the form as it stands; null while there is none. */
  previewed = $state.raw<FormationPreview | null>(null);
  previewFault = $state('');
  outcome = $state.raw<Outcome>(null);

  readonly path: RouteDraft;
  readonly route: RouteDraft;
  routeOutcome = $state.raw<Outcome>(null);

  readonly #session: Session;
  readonly #targets: Targets;
  readonly #journal: Journal;
  readonly #references: () => readonly ReferenceSnapshot[];
  #asked = 0;

  constructor(session: Session, targets: Targets, journal: Journal, references: () => readonly ReferenceSnapshot[]) {
    this.#session = session;
    this.#targets = targets;
    this.#journal = journal;
    this.#references = references;
    this.path = new RouteDraft(() => this.startHeightM());
    this.route = new RouteDraft(() => this.startHeightM());
  }

  #selected = $derived.by<VehicleRow[]>(() => {
    const wanted = new Set(this.#targets.ids);
    return this.#session.rows.filter((row) => wanted.has(row.id));
  });

  /** Who would take part as far as this page can tell: the targets that are in the air and under the swarm's control. */
  members = $derived.by<VehicleRow[]>(() => this.#selected.filter((row) => AVAILABLE.has(row.flightState) && row.staleness !== 'lost'));

  /** Why nobody would; empty where somebody does. */
  whyNobody = $derived.by<string>(() => (this.members.length > 0 ? '' : whyNobody(this.#selected)));

  leaderId = $derived.by<number | null>(() => {
    const ids = this.members.map((row) => row.id);
    for (const id of [this.leader, this.#session.info.formation?.leader ?? null]) {
      if (id !== null && ids.includes(id)) return id;
    }
    return ids[0] ?? null;
  });

  /** How many take part: before take-off the targets. */
  wouldTakePart = $derived.by<number>(() => (this.members.length > 0 ? this.members.length : this.#targets.ids.length));

  offsets = $derived(parseOffsets(this.offsetsText));

  /** What is still missing before this can be asked of the server; empty if nothing is. */
  missing = $derived.by<string>(() => {
    if (hasParameter(this.shape, 'offsets')) {
      if ('fault' in this.offsets) return t('Offsets: {fault}', { fault: this.offsets.fault });
      const lacking = this.wouldTakePart - this.offsets.offsets.length;
      if (lacking > 0) return t('Places missing: {count}', { count: lacking });
    }
    if (this.anchor === 'place' && !this.place) return t('Pick the place on the map');
    if (this.anchor === 'path' && this.path.waypoints.length === 0) return t('Draw the path on the map');
    if (this.anchor === 'reference' && this.referenceName === '') return t('Choose a reference');
    return '';
  });

  #anchor(): FormationAnchor {
    switch (this.anchor) {
      case 'leader':
        return { kind: 'leader' };
      case 'path':
        return { kind: 'path', route: this.path.route() };
      case 'reference':
        return { kind: 'reference', name: this.referenceName };
      case 'place': {
        const { north, east } = this.place ?? { north: 0, east: 0 };
        const down_m = 0 - (this.placeHeightM ?? this.startHeightM() ?? 10);
        return { kind: 'place', position: { north_m: north, east_m: east, down_m }, heading_deg: null };
      }
    }
  }

  request(): FormationRequest {
    const heading: HeadingRequest =
      this.heading === 'fixed' ? { kind: 'fixed', heading_deg: this.headingDeg } : { kind: this.heading };
    return requestOf({
      shape: this.shape,
      spacing_m: this.spacingM,
      heading,
      altitude_step_m: this.altitudeStepM,
      rotation_deg: this.rotationDeg,
      scale: this.scale,
      arcDeg: this.arcDeg,
      layers: this.layers,
      pitchM: this.pitchM,
      offsets: 'offsets' in this.offsets ? this.offsets.offsets : [],
      anchor: this.#anchor(),
      control: this.control,
      leader: this.leader,
      members: this.#targets.ids,
    });
  }

  /** The form as a preview is asked for: with those that would take part, or before take-off with the targets. */
  #previewRequest(): FormationRequest {
    const members = this.members.length > 0 ? this.members.map((row) => row.id) : this.#targets.ids;
    return { ...this.request(), members };
  }

  /** What a new preview is for, as text: a change of it is a reason to ask again. */
  previewKey = $derived.by<string>(() => {
    if (!this.preview || this.missing !== '' || !this.#session.canCommand) return '';
    const request = this.#previewRequest();
    return (request.members?.length ?? 0) === 0 ? '' : JSON.stringify(request);
  });

  /** Asks the server where the places would be once the form has been left alone. Returns how to call it off. */
  askPreview(key: string): () => void {
    const asked = ++this.#asked;
    if (key === '') {
      this.previewed = null;
      this.previewFault = '';
      return () => {};
    }
    const timer = setTimeout(() => {
      previewFormation(JSON.parse(key) as FormationRequest).then(
        (answer) => this.#takePreview(asked, answer, ''),
        (error: unknown) => this.#takePreview(asked, null, error instanceof ApiError ? error.message : String(error)),
      );
    }, SETTLE_MS);
    return () => clearTimeout(timer);
  }

  #takePreview(asked: number, answer: FormationPreview | null, fault: string): void {
    // An answer to what the form said before is no answer to what it says now.
    if (asked !== this.#asked) return;
    this.previewed = answer;
    this.previewFault = fault;
  }

  /** Places of the slots in metres about the swarm's origin, leader first if there is one; empty while the anchor is not known. */
  previewSlots(): Slot[] {
    if (!this.preview || !this.previewed) return [];
    const basis = this.previewBasis();
    return basis ? placed(this.previewed.slots, basis, basis.headingRad) : [];
  }

  /** Who would go from where to which place, if it can be flown now: from where the vehicles have come to since it was asked. */
  previewWays(): { from: Place; to: Place }[] {
    const ways = (this.preview && this.previewed?.forecast?.ways) || [];
    return ways.map(({ vehicle, from, to }) => ({
      from: this.#vehicleAt(vehicle) ?? { north: from.north_m, east: from.east_m },
      to: { north: to.north_m, east: to.east_m },
    }));
  }

  /** What the preview says in words, and whether it says that the order would be refused. */
  previewSaid = $derived.by<{ text: string; refused: boolean }>(() => {
    if (!this.preview || !this.previewed) return { text: '', refused: false };
    const { forecast, refusal, smallest_distance_m: apart, views, looking } = this.previewed;
    // Nobody in the air is no fault of the form; the page says so itself.
    if (refusal && this.members.length > 0) return { text: t('Would be refused: {why}', { why: refusalText(refusal) }), refused: true };
    const said = [];
    if (forecast) said.push(t('{seconds} s to form', { seconds: forecast.receipt.duration_s.toFixed(0) }));
    const onTheWay = forecast?.receipt.planned_min_distance_m ?? null;
    if (onTheWay !== null) said.push(t('closest on the way: {distance}', { distance: figureText('length', onTheWay) }));
    if (apart !== null) said.push(t('closest in place: {distance}', { distance: figureText('length', apart) }));
    const blocked = views.filter((view) => view === 'blocked').length;
    if (looking > 0 && blocked > 0) said.push(t('no free view from {count} of {all} places', { count: blocked, all: views.length }));
    const text = said.join('; ');
    return { text: text.charAt(0).toUpperCase() + text.slice(1), refused: false };
  });

  /** Where the previewed anchor is and where the formation looks there. */
  previewBasis(): (Place & { headingRad: number }) | null {
    if (!this.preview) return null;
    // The coordinator's word where it has one: a formation that turns into another one looks where the first does.
    const fixed = this.heading === 'fixed' ? (this.headingDeg * Math.PI) / 180 : (this.previewed?.forecast?.heading_rad ?? null);
    const at = (place: Place | null | undefined, headingRad: number | null) =>
      place ? { north: place.north, east: place.east, headingRad: fixed ?? headingRad ?? 0 } : null;
    switch (this.anchor) {
      case 'leader': {
        const leader = this.#vehicleAt(this.leaderId ?? this.#targets.ids[0] ?? null);
        return leader && at(leader, leader.headingRad);
      }
      case 'place':
        return at(this.place, null);
      case 'path':
        return at(this.path.waypoints[0], pathHeading(this.path.waypoints));
      case 'reference': {
        const report = this.#references().find((r) => r.name === this.referenceName)?.report;
        return report ? at({ north: report.position.north_m, east: report.position.east_m }, report.heading_rad) : null;
      }
    }
  }

  #vehicleAt(id: number | null): (Place & { headingRad: number }) | null {
    const fleet = this.#session.fleet;
    const index = id === null ? -1 : fleet.indexOf(id);
    if (index < 0 || !fleet.has(index, FLAG.position)) return null;
    return { north: fleet.northM[index] ?? 0, east: fleet.eastM[index] ?? 0, headingRad: fleet.yawRad[index] ?? 0 };
  }

  async send(): Promise<void> {
    const name = label(this.shape);
    const request = this.request();
    this.outcome = { tone: 'pending', text: t('{shape}: asking the coordinator', { shape: name }) };
    try {
      const receipt = await putFormation(request);
      const text = t('{shape} of {count} {anchor}: {seconds} s to form, never closer than {distance}, then up to {speed}', {
        shape: name,
        count: receipt.members.length,
        anchor: anchorText(request.anchor, receipt.leader),
        seconds: receipt.duration_s.toFixed(0),
        distance: receipt.planned_min_distance_m === null ? '–' : figureText('length', receipt.planned_min_distance_m),
        speed: figureText('speed', receipt.max_speed_m_s),
      });
      this.outcome = { tone: 'accepted', text };
      this.preview = false;
    } catch (error) {
      this.outcome = this.#refused(t('{shape} refused', { shape: name }), error);
    }
  }

  async end(): Promise<void> {
    this.outcome = { tone: 'pending', text: t('Ending the formation') };
    try {
      await endFormation();
      this.outcome = { tone: 'accepted', text: t('Formation ended: its vehicles hold') };
    } catch (error) {
      this.outcome = this.#refused(t('Not ended'), error);
    }
  }

  async sendRoute(): Promise<void> {
    const route = this.route.route();
    this.routeOutcome = { tone: 'pending', text: t('Sending the route') };
    try {
      await putRoute(route);
      this.routeOutcome = { tone: 'accepted', text: t('Route of {count} points taken up', { count: route.waypoints.length }) };
      this.route.waypoints = [];
    } catch (error) {
      this.routeOutcome = this.#refused(t('Route refused'), error);
    }
  }

  clearRoute(): void {
    this.route.clear();
    this.routeOutcome = null;
  }

  /** The server began anew: what it said to the last orders, and who was to lead, is over. The form stays. */
  restart(): void {
    this.leader = this.outcome = this.routeOutcome = null;
  }

  /** Height of the leader, or of whoever would be it, above the swarm's origin, to the half metre; null if nobody flies. */
  startHeightM(): number | null {
    const { fleet, info } = this.#session;
    const leader = info.formation?.leader ?? this.leaderId;
    const index = leader === null ? -1 : fleet.indexOf(leader);
    const ground = info.frame?.origin.altitude_amsl_m ?? fleet.projection?.origin.altitude_amsl_m ?? 0;
    return index < 0 ? null : Math.max(2, Math.round(((fleet.altitudeM[index] ?? 0) - ground) * 2) / 2);
  }

  #refused(what: string, error: unknown): Outcome {
    const why = error instanceof ApiError ? error.message : String(error);
    this.#journal.notice('warning', 'formation', `${what}: ${why}`);
    return { tone: 'refused', text: `${what}: ${why}` };
  }
}
