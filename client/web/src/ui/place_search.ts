// A field for a place on a globe, by its coordinates: Enter goes there.
import { said } from './language';
import { placeOf, type PlaceView } from '../globe/place_text';
import { reasonOf } from './words';

export class PlaceSearch {
  private readonly field = Object.assign(document.createElement('input'), { type: 'search', name: 'place', autocomplete: 'off', spellcheck: false });

  constructor(tools: HTMLElement, onPlace: (view: PlaceView) => void, say: (text: string) => void) {
    const { field } = this, form = document.createElement('form');
    Object.assign(field, { placeholder: said('Latitude, longitude'), ariaLabel: said('Latitude, longitude'), hidden: true });
    form.append(field);
    tools.append(form);
    form.onsubmit = (event) => {
      event.preventDefault();
      try {
        onPlace(placeOf(field.value));
        field.blur();
      } catch (error) {
        say(reasonOf(error));
      }
    };
  }
  setOn(is_on: boolean): void {
    this.field.hidden = !is_on;
  }
}
